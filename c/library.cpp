// Versions, and what this build of the library contains.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "plait.h"
#include "plait/detail/scheme.h"
#include "plait/extend/provenance.h"
#include "plait/layout.h"
#include "plait/registry.h"
#include "plait/subdivide.h"

namespace {

std::string build_info() {
  using namespace plait;
  std::vector<std::string_view> scheme_list, executors, layouts;
  for (const SchemeTraits& scheme : schemes()) scheme_list.push_back(scheme.name);
  for (const ExecutorKind kind : {ExecutorKind::kAuto, ExecutorKind::kFused, ExecutorKind::kSweep,
                                  ExecutorKind::kTransparent})
    executors.push_back(to_string(kind));
  for (const LayoutKind kind : {LayoutKind::kGiven, LayoutKind::kSpatial, LayoutKind::kHilbert,
                                LayoutKind::kRcm, LayoutKind::kAutomatic})
    layouts.push_back(to_string(kind));
  return fmt::format(
      "version: {}\nbackends: {}\ncodecs: {}\nfilters: {}\nschemes: {}\nexecutors: {}\n"
      "layouts: {}\n",
      program_version(), fmt::join(default_backends().names(), " "),
      fmt::join(default_pipelines().codec_names(), " "),
      fmt::join(default_pipelines().filter_names(), " "), fmt::join(scheme_list, " "),
      fmt::join(executors, " "), fmt::join(layouts, " "));
}

/// Without memory for the text, the answer is empty.
template <class Make>
std::string made(Make make) noexcept {
  try {
    return make();
  } catch (...) {
    return {};
  }
}

}  // namespace

uint32_t plait_abi_version(void) { return PLAIT_ABI_VERSION; }

const char* plait_version_string(void) {
  static const std::string version = made(plait::program_version);
  return version.c_str();
}

const char* plait_build_info(void) {
  static const std::string info = made(build_info);
  return info.c_str();
}
