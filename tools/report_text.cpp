#include "report_text.h"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "argument_text.h"
#include "arguments.h"
#include "built_in_backends.h"
#include "console.h"
#include "json_text.h"
#include "plait/detail/scheme.h"
#include "plait/error.h"
#include "plait/version.h"

namespace plait {
namespace {

using Json = nlohmann::ordered_json;

struct RepairLine {
  const char* name;  ///< in JSON
  const char* text;
};
constexpr std::array<RepairLine, 13> kRepairLines = {{
    {"not_finite_vertices", "vertices with coordinates that are not finite"},
    {"not_finite_faces", "faces at such vertices: removed"},
    {"degenerate_faces", "faces with a vertex twice: removed"},
    {"duplicate_faces", "faces given twice: removed"},
    {"needle_faces", "faces without area: they stay"},
    {"non_manifold_edges", "edges of more than two faces: cut apart"},
    {"turned_faces", "faces of the wrong orientation: turned"},
    {"non_manifold_vertices", "vertices of several fans: a vertex for each"},
    {"small_components", "small components: removed"},
    {"small_component_faces", "faces of small components"},
    {"filled_holes", "holes: filled"},
    {"filled_hole_faces", "faces that fill holes"},
    {"unused_vertices", "vertices that no face uses: removed"},
}};

std::string count_text(const Json& count) { return format_count(count.get<std::uint64_t>()); }

std::string counted(std::uint64_t count, const char* one, const char* many) {
  if (count == 0) return fmt::format("no {}", one);
  return fmt::format("{} {}", format_count(count), count == 1 ? one : many);
}

}  // namespace

std::string rounding_text(const Json& rounding) {
  return fmt::format(
      "rounded to steps of {:.6g}: error at most {:.6g} ({}), largest found {:.6g}, root mean "
      "square {:.6g}",
      rounding["step"].get<double>(), rounding["bound"].get<double>(),
      rounding["metric"].get<std::string>(), rounding["largest_error"].get<double>(),
      rounding["rms_error"].get<double>());
}

std::string made_blocks_text(const Json& made) {
  return fmt::format("{}: {} of {} blocks take no bytes; reading makes them again ({})\n",
                     made["attribute"].get<std::string>(), count_text(made["made"]),
                     count_text(made["blocks"]), made["recipe"].get<std::string>());
}

std::string repair_text(const Json& repairs) {
  std::string text;
  for (const RepairLine& line : kRepairLines)
    if (repairs[line.name].get<std::uint64_t>() > 0)
      text += fmt::format("  {} {}\n", count_text(repairs[line.name]), line.text);
  return text;
}

std::string figures_text(const Json& figures) {
  const auto number = [&](const char* name) { return figures[name].get<std::uint64_t>(); };
  return fmt::format(
      "{} vertices, {} edges, {} faces; {}, {}, Euler number {}", count_text(figures["vertices"]),
      count_text(figures["edges"]), count_text(figures["faces"]),
      counted(number("components"), "component", "components"),
      counted(number("borders"), "border", "borders"), figures["euler_number"].get<std::int64_t>());
}

std::string distances_text(std::string_view name, const Json& distances, double diagonal,
                           double mean_edge) {
  const auto number = [&](const char* of) { return distances[of].get<double>(); };
  const auto of_diagonal = [&](const char* of) { return 100 * number(of) / diagonal; };
  return fmt::format(
      "{}: RMS {:.4f} %, mean {:.4f} %, 99 % below {:.4f} %, 99.9 % below {:.4f} %, max {:.4f} % "
      "of "
      "the diagonal\n"
      "  RMS {:.3f}, max {:.2f} mean edges; normals differ by {:.2f} degrees in the mean, 99 % by "
      "less than {:.1f}\n",
      name, of_diagonal("rms"), of_diagonal("mean"), of_diagonal("percentile_99"),
      of_diagonal("percentile_99_9"), of_diagonal("max"), number("rms") / mean_edge,
      number("max") / mean_edge, number("mean_normal_degrees"),
      number("percentile_99_normal_degrees"));
}

}  // namespace plait

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

namespace plait {

nlohmann::ordered_json to_json(const std::vector<DamagedBlock>& blocks) {
  nlohmann::ordered_json result = nlohmann::ordered_json::array();
  for (const DamagedBlock& block : blocks)
    result.push_back({{"attribute", block.attribute},
                      {"level", block.level},
                      {"block", block.block},
                      {"file_offset", block.file_offset},
                      {"first_edge", block.first_edge},
                      {"edge_after", block.edge_after},
                      {"reason", block.reason}});
  return result;
}

std::string to_text(std::string_view word, const std::vector<DamagedBlock>& blocks,
                    std::uint64_t count) {
  std::string text;
  for (const DamagedBlock& block : blocks)
    text += fmt::format("{}: {}, level {}, block {}, file offset {}, edges {} to {}: {}\n", word,
                        block.attribute, block.level, block.block, block.file_offset,
                        block.first_edge, block.edge_after - 1, block.reason);
  if (count > blocks.size())
    text += fmt::format("{}: and {} blocks more\n", word, format_count(count - blocks.size()));
  return text;
}

std::string to_text(const std::vector<std::string>& left_over,
                    const std::vector<std::string>& notes) {
  std::string text;
  for (const std::string& note : notes) text += fmt::format("note: {}\n", note);
  for (const std::string& name : left_over)
    text += fmt::format("left over: {}: no version refers to it\n", name);
  return text;
}

}  // namespace plait

namespace plait {

int report_incomplete(const std::filesystem::path& plan, const JoinResult& parts, bool json) {
  for (const std::string& reason : parts.reasons) report_warning(reason);
  if (json)
    print(json_text(nlohmann::ordered_json({{"plan", plan.string()},
                                            {"missing", parts.missing},
                                            {"bad", parts.bad},
                                            {"array", parts.again()}})));
  else
    print(parts.again() + "\n");
  return kExitIncomplete;
}

int report_join(const JoinResult& joined, const std::filesystem::path& plan,
                const std::filesystem::path& store, double seconds, bool json) {
  if (!joined.has_store) return report_incomplete(plan, joined, json);
  if (!json) {
    print(fmt::format("{}: version {}{}, {:.2f} s\n{}\n", store.native(), joined.version,
                      joined.was_joined ? " was joined before" : "", seconds, joined.digest));
    return kExitDone;
  }
  const nlohmann::ordered_json report = {
      {"plan", plan.string()},   {"store", store.string()},         {"version", joined.version},
      {"digest", joined.digest}, {"was_joined", joined.was_joined}, {"seconds", seconds}};
  print(json_text(report));
  return kExitDone;
}

}  // namespace plait
