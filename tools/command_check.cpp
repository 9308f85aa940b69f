// plait check: says what is wrong with a mesh, and changes nothing.

#include <fmt/format.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "argument_text.h"
#include "job_command.h"
#include "mesh/weld.h"
#include "report_text.h"

namespace plait {
namespace {

std::string check_text(const nlohmann::ordered_json& report) {
  const bool clean = report["found"]["clean"].get<bool>();
  const auto seam_vertices = report["seam_vertices"].get<std::uint64_t>();
  const auto folded_edges = report["repaired"]["folded_edges"].get<std::uint64_t>();
  const std::string seams = seam_vertices == 0 ? "" : seam_text(seam_vertices) + "\n";
  const std::string folded =
      folded_edges == 0
          ? ""
          : fmt::format(
                "edges folded over 150 degrees: {}\nsmall faces are turned over there, so "
                "remesh --no-foldover may refuse the mesh\n",
                format_count(folded_edges));
  return fmt::format(
      "{}: {}\n{}{}{}\n{}{}", report["mesh"].get<std::string>(),
      clean ? "an oriented manifold" : "not an oriented manifold as it is; remesh would repair it:",
      repair_text(report["found"]), clean ? "" : "then: ", figures_text(report["repaired"]), seams,
      folded);
}

}  // namespace

void add_check_command(CommandLine& program, CommandContext& context) {
  add_job_command(
      program, context,
      {"check",
       "The list is that of the repairs that remeshing does. A mesh that cannot be oriented, such "
       "as a\n"
       "Moebius strip, is refused with the place.\n"
       "\n"
       "Examples:\n"
       "  plait check scan.ply\n"
       "  plait check scan.ply --weld 1e-6\n"
       "  plait check scan.ply --json",
       check_text});
}

}  // namespace plait
