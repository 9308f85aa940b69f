#include "plugins/registration.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <string_view>
#include <utility>

#include "plait/error.h"
#include "plugins/function_codec.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// A message of a plug-in may have any length and any characters; ours is one line.
std::string one_line(std::string_view text) {
  constexpr std::size_t kMostCharacters = 500;
  std::string line(text.substr(0, kMostCharacters));
  std::ranges::replace_if(
      line, [](char c) { return c >= 0 && c < ' '; }, ' ');
  return line;
}

Registration& registration_of(const plait_host* host) {
  return *static_cast<Registration*>(host->registry);
}

}  // namespace

Registration::Registration(const std::filesystem::path& file, const BackendRegistry& backends,
                           const PipelineRegistry& pipelines)
    : host_{sizeof(plait_host),
            PLAIT_PLUGIN_ABI_VERSION,
            PLAIT_VERSION,
            this,
            add_codec,
            add_filter,
            refuse,
            cpp_registry},
      backends_(backends),
      pipelines_(pipelines) {
  added_.file = file;
}

void Registration::run(PluginFunction entry) {
  try {
    const std::int32_t status = entry(&host_);
    if (status != 0)
      fail(ErrorCode::kNotSupported, fmt::format("plait_plugin_v1 returned {}", status));
  } catch (const std::exception& error) {
    fail(ErrorCode::kNotSupported, fmt::format("plait_plugin_v1 threw: {}", error.what()));
  } catch (...) {
    fail(ErrorCode::kNotSupported, "plait_plugin_v1 threw an exception");
  }
  if (failed_)
    throw Error(code_, fmt::format("load plug-in {}: {}", added_.file.native(), reason_));
}

void Registration::add(RegisteredBackend entry) {
  keep_error([&] {
    const std::string name = entry.name;
    if (!name.empty() && !is_stage_name(name))
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("add backend \"{}\": expected a name of [A-Za-z0-9_-]", name));
    backends_.add(entry);
    own_backends_.push_back(std::move(entry));
    added_.backends.push_back(name);
  });
}

void Registration::add(RegisteredCodec entry) {
  keep_error([&] {
    added_.codecs.push_back(entry.name);
    pipelines_.add(std::move(entry));
  });
}

void Registration::add(RegisteredFilter entry) {
  keep_error([&] {
    added_.filters.push_back(entry.name);
    pipelines_.add(std::move(entry));
  });
}

template <class Addition>
void Registration::keep_error(const Addition& addition) {
  try {
    addition();
  } catch (const Error& error) {
    fail(error.code(), error.what());
    throw;
  } catch (const std::exception& error) {
    fail(ErrorCode::kOutOfMemory, error.what());
    throw;
  }
}

void Registration::fail(ErrorCode code, std::string_view reason) {
  if (std::exchange(failed_, true)) return;
  code_ = code;
  reason_ = one_line(reason);
}

std::int32_t Registration::add_codec(const plait_host* host, const plait_codec* codec) noexcept {
  Registration& here = registration_of(host);
  try {
    here.keep_error([&] { here.add(entry_of(codec)); });
    return 0;
  } catch (...) {
    return 1;
  }
}

std::int32_t Registration::add_filter(const plait_host* host, const plait_filter* filter) noexcept {
  Registration& here = registration_of(host);
  try {
    here.keep_error([&] { here.add(entry_of(filter)); });
    return 0;
  } catch (...) {
    return 1;
  }
}

void Registration::refuse(const plait_host* host, const char* reason) noexcept {
  registration_of(host).fail(ErrorCode::kNotSupported, reason == nullptr ? "no reason" : reason);
}

void* Registration::cpp_registry(const plait_host* host, const char* stamp) noexcept {
  Registration& here = registration_of(host);
  const std::string_view found = stamp == nullptr ? "" : stamp;
  if (found == PLAIT_CPP_STAMP) return static_cast<PluginRegistry*>(&here);
  here.fail(ErrorCode::kNotSupported,
            fmt::format("expected a plug-in built against \"{}\", found \"{}\": build it anew with "
                        "the headers of this version",
                        PLAIT_CPP_STAMP, found.substr(0, 200)));
  return nullptr;
}

PLAIT_END_NAMESPACE
