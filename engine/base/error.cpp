#include "plait/error.h"

#include <fmt/format.h>

#include <cerrno>
#include <system_error>

#include "base/text.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

namespace {

constexpr NameTable<ErrorCode, 11> kCodes("error code",
                                          {{ErrorCode::kNotFound, "not_found"},
                                           {ErrorCode::kInvalidArgument, "invalid_argument"},
                                           {ErrorCode::kCorruption, "corruption"},
                                           {ErrorCode::kNotSupported, "not_supported"},
                                           {ErrorCode::kIo, "io"},
                                           {ErrorCode::kNoSpace, "no_space"},
                                           {ErrorCode::kOutOfMemory, "out_of_memory"},
                                           {ErrorCode::kBudget, "budget"},
                                           {ErrorCode::kBusy, "busy"},
                                           {ErrorCode::kBadState, "bad_state"},
                                           {ErrorCode::kCancelled, "cancelled"}});

}  // namespace

std::string_view to_string(ErrorCode code) noexcept { return kCodes.name_of(code); }

const std::filesystem::path& Error::path() const noexcept {
  static const std::filesystem::path none;
  return place_ ? place_->path : none;
}

std::optional<std::uint64_t> Error::offset() const noexcept {
  return place_ ? place_->offset : std::nullopt;
}

Error Error::about(const std::filesystem::path& file, std::optional<std::uint64_t> offset) const {
  Error result(*this);
  result.place_ = std::make_shared<const FilePlace>(FilePlace{file, offset});
  return result;
}

Error out_of_memory(std::string_view verb) {
  return Error(ErrorCode::kOutOfMemory,
               fmt::format("{}: expected enough memory, found too little", verb));
}

Error system_error(std::string_view verb, std::string_view path, int errno_value,
                   std::optional<std::uint64_t> offset) {
  const ErrorCode code = errno_value == ENOSPC || errno_value == EDQUOT ? ErrorCode::kNoSpace
                         : errno_value == ENOENT                        ? ErrorCode::kNotFound
                         : errno_value == ENOMEM                        ? ErrorCode::kOutOfMemory
                                                                        : ErrorCode::kIo;
  return Error(code,
               fmt::format("{} {}: {}", verb, path, std::generic_category().message(errno_value)))
      .about(path, offset);
}

PLAIT_END_NAMESPACE
