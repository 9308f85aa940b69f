// plait compare: the distances between two surfaces, in both directions.

#include <fmt/format.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "argument_text.h"
#include "job_command.h"
#include "report_text.h"

namespace plait {
namespace {

std::string compare_text(const nlohmann::ordered_json& report) {
  const auto diagonal = report["diagonal"].get<double>();
  const auto mean_edge = report["mean_edge"].get<double>();
  return fmt::format("{}{}diagonal {:.6g}, mean edge {:.6g} of {}; {} samples in each direction\n",
                     distances_text("A to B", report["a_to_b"], diagonal, mean_edge),
                     distances_text("B to A", report["b_to_a"], diagonal, mean_edge), diagonal,
                     mean_edge, report["a"].get<std::string>(),
                     format_count(report["a_to_b"]["samples"].get<std::uint64_t>()));
}

}  // namespace

void add_compare_command(CommandLine& program, CommandContext& context) {
  add_job_command(
      program, context,
      {"compare",
       "Each sample is a point of one surface; its distance is that to the closest point of the\n"
       "other one. The two directions differ where one surface has parts that the other lacks.\n"
       "Percentages are of the diagonal of the box around A. The surfaces have to fit in memory.\n"
       "\n"
       "Examples:\n"
       "  plait compare scan.ply scan.plait\n"
       "  plait compare scan.ply scan.plait --level 2 --samples 10000000",
       compare_text});
}

}  // namespace plait
