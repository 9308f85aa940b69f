#include "build_report.h"

#include <fmt/format.h>

#include "plait/detail/scheme.h"
#include "plait/error.h"
#include "plait/version.h"
#include "uring/uring_backend.h"

namespace plait {
namespace {

using Json = nlohmann::ordered_json;

#if defined(__clang__)
constexpr const char* kCompiler = "clang " __clang_version__;
#elif defined(__GNUC__)
constexpr const char* kCompiler = "gcc " __VERSION__;
#else
constexpr const char* kCompiler = "unknown";
#endif

Json backend_json(const RegisteredBackend& backend) {
  Json json = {{"name", backend.name}, {"summary", backend.summary}, {"available", true}};
  try {
    backend.check_machine();
    if (backend.name == "uring") check_uring();  // pread would stand in for it
  } catch (const Error& error) {
    json["available"] = false;
    json["reason"] = error.what();
  }
  return json;
}

std::string list_of(const Json& names) {
  std::string text;
  for (const Json& name : names) text += (text.empty() ? "" : ", ") + name.get<std::string>();
  return text;
}

}  // namespace

Json build_report(const Plugins& plugins) {
  const BackendRegistry& backends = plugins.backends();
  Json report = {{"version", PLAIT_VERSION}, {"compiler", kCompiler}};
  report["backends"] = Json::array();
  for (const std::string& name : backends.names())
    report["backends"].push_back(backend_json(backends.find(name)));
  report["codecs"] = plugins.pipelines().codec_names();
  report["filters"] = plugins.pipelines().filter_names();
  report["schemes"] = Json::array();
  for (const SchemeTraits& scheme : schemes()) report["schemes"].push_back(scheme.name);
  report["plugins"] = Json::array();
  for (const LoadedPlugin& plugin : plugins.loaded())
    report["plugins"].push_back({{"file", plugin.file.native()},
                                 {"backends", plugin.backends},
                                 {"codecs", plugin.codecs},
                                 {"filters", plugin.filters}});
  return report;
}

std::string build_text(const Json& report) {
  std::string text =
      fmt::format("version    {}\ncompiler   {}\nbackends\n", report["version"].get<std::string>(),
                  report["compiler"].get<std::string>());
  for (const Json& backend : report["backends"]) {
    text += fmt::format("  {:<10} {}\n", backend["name"].get<std::string>(),
                        backend["summary"].get<std::string>());
    if (backend.contains("reason"))
      text += fmt::format("  {:<10} not available here: {}\n", "",
                          backend["reason"].get<std::string>());
  }
  for (const char* const kind : {"codecs", "filters", "schemes"})
    text += fmt::format("{:<10} {}\n", kind, list_of(report[kind]));
  for (const Json& plugin : report["plugins"]) {
    text += fmt::format("plug-in    {}\n", plugin["file"].get<std::string>());
    for (const char* const kind : {"backends", "codecs", "filters"})
      if (!plugin[kind].empty()) text += fmt::format("  {:<10} {}\n", kind, list_of(plugin[kind]));
  }
  return text;
}

}  // namespace plait
