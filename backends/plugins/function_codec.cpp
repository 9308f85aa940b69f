#include "plugins/function_codec.h"

#include <fmt/format.h>

#include <memory>
#include <string>

#include "base/text.h"
#include "plait/error.h"
#include "plait/extend/codec.h"
#include "plait/extend/filter.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

[[noreturn]] void refuse_function(const char* kind, const char* name, std::string_view expected) {
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("register {} \"{}\": expected {}", kind, name, expected));
}

/// A structure of a plug-in, with the checks that codecs and filters share.
template <class Functions>
Functions checked(const Functions* given, const char* kind) {
  if (given == nullptr) refuse_function(kind, "", "a structure, found NULL");
  if (given->struct_size != sizeof(Functions))
    refuse_function(kind, "",
                    fmt::format("a structure of {} bytes, found one of {}", sizeof(Functions),
                                given->struct_size));
  if (given->name == nullptr) refuse_function(kind, "", "a name, found NULL");
  if (given->summary == nullptr) refuse_function(kind, given->name, "a summary, found NULL");
  return *given;
}

/// What open() of a plug-in made.
class State {
 public:
  template <class Functions>
  State(const Functions& functions, const char* kind, const std::string& name,
        std::string_view options)
      : close_(functions.close) {
    if (functions.open == nullptr) {
      if (options.empty()) return;
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("choose {} \"{}\": expected no options, found \"{}\"", kind, name,
                              text_for_message(options)));
    }
    state_ = functions.open(std::string(options).c_str());
    if (state_ == nullptr)
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("choose {} \"{}\": the plug-in refuses the options \"{}\"", kind,
                              name, text_for_message(options)));
  }
  ~State() {
    if (state_ != nullptr && close_ != nullptr) close_(state_);
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  void* get() const { return state_; }

 private:
  void (*close_)(void* state);
  void* state_ = nullptr;
};

class FunctionCodec final : public Codec {
 public:
  FunctionCodec(const plait_codec& functions, std::string name, std::string_view options)
      : functions_(functions),
        name_(std::move(name)),
        state_(functions_, "codec", name_, options) {}

  std::size_t bound(std::size_t raw_bytes) const override {
    return functions_.bound(state_.get(), raw_bytes);
  }
  std::size_t memory_bytes(std::size_t raw_bytes) const override {
    return functions_.memory_bytes == nullptr ? 0
                                              : functions_.memory_bytes(state_.get(), raw_bytes);
  }
  std::optional<std::size_t> compress(std::span<const std::byte> raw,
                                      std::span<std::byte> into) override {
    const std::size_t bytes =
        functions_.compress(state_.get(), raw.data(), raw.size(), into.data(), into.size());
    if (bytes > into.size())
      throw Error(ErrorCode::kBadState,
                  fmt::format("encode {}: expected at most {} bytes, and the plug-in reports {}",
                              name_, into.size(), bytes));
    if (bytes == 0) return std::nullopt;
    return bytes;
  }
  void decompress(std::span<const std::byte> stored, std::span<std::byte> raw) override {
    if (functions_.decompress(state_.get(), stored.data(), stored.size(), raw.data(), raw.size()) !=
        0)
      throw Error(ErrorCode::kCorruption, fmt::format("decode {}: expected {} bytes, found a "
                                                      "damaged stream",
                                                      name_, raw.size()));
  }

 private:
  plait_codec functions_;
  std::string name_;
  State state_;
};

class FunctionFilter final : public Filter {
 public:
  FunctionFilter(const plait_filter& functions, const std::string& name, std::string_view options,
                 std::size_t component_bytes)
      : functions_(functions),
        state_(functions_, "filter", name, options),
        component_bytes_(component_bytes) {}

  void encode(const FilterBlock&, std::span<const std::byte> raw,
              std::span<std::byte> filtered) const override {
    functions_.encode(state_.get(), raw.data(), filtered.data(), raw.size(), component_bytes_);
  }
  void decode(const FilterBlock&, std::span<const std::byte> filtered,
              std::span<std::byte> raw) const override {
    functions_.decode(state_.get(), filtered.data(), raw.data(), raw.size(), component_bytes_);
  }

 private:
  plait_filter functions_;
  State state_;
  std::size_t component_bytes_;
};

}  // namespace

RegisteredCodec entry_of(const plait_codec* codec) {
  const plait_codec functions = checked(codec, "codec");
  if (functions.bound == nullptr || functions.compress == nullptr ||
      functions.decompress == nullptr)
    refuse_function("codec", functions.name,
                    "the functions bound, compress and decompress, found NULL");
  return {functions.name, functions.summary,
          [functions, name = std::string(functions.name)](std::string_view options) {
            return std::make_unique<FunctionCodec>(functions, name, options);
          }};
}

RegisteredFilter entry_of(const plait_filter* filter) {
  const plait_filter functions = checked(filter, "filter");
  if (functions.encode == nullptr || functions.decode == nullptr)
    refuse_function("filter", functions.name, "the functions encode and decode, found NULL");
  return {functions.name, functions.summary,
          [functions, name = std::string(functions.name)](std::string_view options,
                                                          const FilterLevel& level) {
            return std::make_unique<FunctionFilter>(functions, name, options,
                                                    component_bytes(level.schema.type));
          }};
}

PLAIT_END_NAMESPACE
