#include "guard.h"

#include <fmt/format.h>

#include <exception>
#include <new>
#include <optional>
#include <stdexcept>
#include <utility>

#include "base/caught.h"

namespace plait::c {
namespace {

/// What the last failed call of a thread has said.
class LastError {
 public:
  const char* message() const noexcept { return fixed_ != nullptr ? fixed_ : text_.c_str(); }
  const char* path() const noexcept { return path_.c_str(); }
  std::uint64_t offset() const noexcept { return offset_; }
  /// Keeps a text that is valid for ever. Needs no memory.
  void keep_fixed(const char* text) noexcept {
    fixed_ = text;
    path_.clear();
    offset_ = PLAIT_NO_OFFSET;
  }
  void keep(const char* call, const char* reason, const std::string& path = {},
            std::optional<std::uint64_t> offset = {}) noexcept {
    try {
      text_ = fmt::format("{}: {}", call, reason);
      path_ = path;
      offset_ = offset.value_or(PLAIT_NO_OFFSET);
      fixed_ = nullptr;
    } catch (...) {
      keep_fixed("no memory for the message");
    }
  }

 private:
  std::string text_, path_;
  std::uint64_t offset_ = PLAIT_NO_OFFSET;
  const char* fixed_ = nullptr;
};

LastError& last_error() noexcept {
  thread_local LastError error;
  return error;
}

// Statuses of plait.h are in the order of ErrorCode, after PLAIT_OK.
constexpr plait_status in_order(ErrorCode code) { return static_cast<plait_status>(code) + 1; }
static_assert(in_order(ErrorCode::kNotFound) == PLAIT_ERROR_NOT_FOUND &&
              in_order(ErrorCode::kInvalidArgument) == PLAIT_ERROR_INVALID_ARGUMENT &&
              in_order(ErrorCode::kCorruption) == PLAIT_ERROR_CORRUPTION &&
              in_order(ErrorCode::kNotSupported) == PLAIT_ERROR_NOT_SUPPORTED &&
              in_order(ErrorCode::kIo) == PLAIT_ERROR_IO &&
              in_order(ErrorCode::kNoSpace) == PLAIT_ERROR_NO_SPACE &&
              in_order(ErrorCode::kOutOfMemory) == PLAIT_ERROR_OUT_OF_MEMORY &&
              in_order(ErrorCode::kBudget) == PLAIT_ERROR_BUDGET &&
              in_order(ErrorCode::kBusy) == PLAIT_ERROR_BUSY &&
              in_order(ErrorCode::kBadState) == PLAIT_ERROR_BAD_STATE &&
              in_order(ErrorCode::kCancelled) == PLAIT_ERROR_CANCELLED);

plait_status status_of(ErrorCode code) noexcept { return in_order(code); }

std::optional<ErrorCode> code_of(plait_status status) noexcept {
  if (status < PLAIT_ERROR_NOT_FOUND || status > PLAIT_ERROR_CANCELLED) return std::nullopt;
  return static_cast<ErrorCode>(status - 1);
}

}  // namespace

plait_status keep_current_error(const char* call) {
  const std::exception_ptr caught = caught_exception();
  try {
    std::rethrow_exception(caught);
  } catch (const Error& error) {
    last_error().keep(call, error.what(), error.path().native(), error.offset());
    return status_of(error.code());
  } catch (const std::bad_alloc&) {
    last_error().keep_fixed("an allocation failed");
    return PLAIT_ERROR_OUT_OF_MEMORY;
  } catch (const std::length_error&) {
    last_error().keep_fixed("an allocation failed: a count is too large");
    return PLAIT_ERROR_OUT_OF_MEMORY;
  } catch (const std::exception& error) {
    last_error().keep(call, error.what());
    return PLAIT_ERROR_INTERNAL;
  } catch (...) {
    last_error().keep(call, "an exception of an unknown type");
    return PLAIT_ERROR_INTERNAL;
  }
}

void refuse_null(const char* argument) {
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("expected a value for '{}', found NULL", argument));
}

void check_choice(const char* what, std::int32_t found, std::int32_t count) {
  if (found < 0 || found >= count)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: expected 0 to {}, found {}", what, count - 1, found));
}

void check_reserved(std::int32_t found) {
  if (found != 0)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("member 'reserved': expected 0, found {}", found));
}

void refuse_cancelled(const char* what) {
  throw Error(ErrorCode::kCancelled, fmt::format("{}: cancelled by the callback", what));
}

void throw_failed(const char* what, plait_status status) {
  if (const auto code = code_of(status))
    throw Error(*code, fmt::format("{}: {}", what, last_error().message()));
  throw std::runtime_error(fmt::format("{} has returned {}", what, status));
}

}  // namespace plait::c

const char* plait_error_message(void) { return plait::c::last_error().message(); }
const char* plait_error_path(void) { return plait::c::last_error().path(); }
uint64_t plait_error_offset(void) { return plait::c::last_error().offset(); }

const char* plait_status_name(plait_status status) {
  if (status == PLAIT_OK) return "ok";
  if (status == PLAIT_ERROR_INTERNAL) return "internal";
  if (const auto code = plait::c::code_of(status))
    return plait::to_string(*code).data();  // a literal, so a zero byte follows
  return "unknown";
}
