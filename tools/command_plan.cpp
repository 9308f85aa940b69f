// plait plan: cuts a subdivision, or a pass over a store in shards, into parts that many machines
// can make.

#include <fmt/format.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "base/text.h"
#include "job_command.h"

namespace plait {
namespace {

using Json = nlohmann::ordered_json;

std::string part_line(std::size_t number, const Json& part) {
  return fmt::format("part {}: edges {} to {}, {}, {:.1f} % ghosts, about {:.3g} s\n", number,
                     part["first_edge"].get<std::uint64_t>(),
                     part["edge_after"].get<std::uint64_t>(),
                     format_bytes(part["bytes"].get<std::uint64_t>()),
                     100 * part["ghost_faces"].get<double>() / part["faces"].get<double>(),
                     part["seconds"].get<double>());
}

std::string what_is_planned(const Json& report) {
  std::string text;
  if (report.contains("pass")) {
    text += fmt::format("pass {} over version {} of {} makes '{}'\n",
                        report["pass"].get<std::string>(), report["version"].get<std::uint64_t>(),
                        report["store"].get<std::string>(), report["attribute"].get<std::string>());
  }
  if (report.contains("rates")) {
    const auto rate = [&](const char* name) { return report["rates"][name].get<double>(); };
    text += fmt::format(
        "this machine, one thread: {:.1f} M points/s, {}/s written and synced, {:.2g} s "
        "to begin a part (measured)\n",
        1e-6 * rate("points_per_second"),
        format_bytes(static_cast<std::uint64_t>(rate("bytes_per_second"))), rate("begin_seconds"));
  }
  return text;
}

std::string plan_text(const Json& report) {
  std::string text = what_is_planned(report);
  const Json& parts = report["parts"];
  const Json& worst = report["worst"];
  constexpr std::size_t kMostLines = 16;
  if (parts.size() <= kMostLines) {
    for (std::size_t at = 0; at < parts.size(); ++at) text += part_line(at, parts[at]);
  } else {
    const auto number = worst["part"].get<std::size_t>();
    text += "the worst: " + part_line(number, parts[number]);
  }
  if (report.contains("memory"))
    text += fmt::format("each part: --memory {}, about {} of memory, with one thread\n",
                        format_bytes(report["memory"]["budget_bytes"].get<std::uint64_t>()),
                        format_bytes(report["memory"]["total_bytes"].get<std::uint64_t>()));
  double faces = 0;
  for (const Json& part : parts) faces += part["faces"].get<double>();
  return text + fmt::format(
                    "{}: {} parts, level {}, {} vertices, {} in {} files, {:.1f} % ghosts, about "
                    "{:.3g} s in all and {:.3g} s for the worst part ({})\n",
                    report["plan"].get<std::string>(), parts.size(), report["levels"].get<int>(),
                    report["vertices"].get<std::uint64_t>(),
                    format_bytes(report["bytes"].get<std::uint64_t>()),
                    report["files"].get<std::uint64_t>(),
                    100 * report["ghost_faces"].get<double>() / faces,
                    report["seconds_of_parts"].get<double>(), worst["seconds"].get<double>(),
                    report.contains("rates") ? "one thread of this machine"
                                             : "estimates for one thread of an ordinary machine");
}

}  // namespace

void add_plan_command(CommandLine& program, CommandContext& context) {
  add_job_command(
      program, context,
      {"plan",
       "plait part makes each part, on any machine that sees PLAN, in any order; plait join makes\n"
       "the store of them. The store's digest is that of plait subdivide with the same options.\n"
       "Parts have raw blocks, or with --compress blocks of a pipeline without prediction: fast.\n"
       "\n"
       "With --pass, the parts are the shards of a store that plait join has made, and plait join\n"
       "commits its next version. A pass reads the last commit, so five iterations are five "
       "plans,\n"
       "one after another. smooth and noise replace the positions. normals makes or replaces the\n"
       "normals; no other pass does.\n"
       "\n"
       "With --of, INPUT is a store that plait join has made. The plan is that of its subdivision\n"
       "again: make the parts whose shards are damaged, and join PLAN into the store.\n"
       "\n"
       "The script of --sbatch asks for the memory and the time of the worst part.\n"
       "\n"
       "Examples:\n"
       "  plait plan --of molecule.plait again.plan\n"
       "  plait plan --pass smooth --factor 0.3 molecule.plait smooth1.plan\n"
       "  plait plan --pass normals molecule.plait normals.plan --sbatch normals.sh\n"
       "  plait plan molecule.ply molecule.plan --levels 5 --normals --parts 4\n"
       "  plait plan statue.ply statue.plan --levels 8 --parts 1000 --calibrate --sbatch statue.sh",
       plan_text});
}

}  // namespace plait
