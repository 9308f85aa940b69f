// plait part: makes one part of a plan.

#include <fmt/format.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "base/text.h"
#include "job_command.h"

namespace plait {
namespace {

std::string part_text(const nlohmann::ordered_json& report) {
  const auto part = report["part"].get<std::uint32_t>();
  if (report["was_done"].get<bool>()) return fmt::format("part {}: it is done already\n", part);
  return fmt::format("part {}: {}, {:.3g} s\n", part,
                     format_bytes(report["bytes"].get<std::uint64_t>()),
                     report["seconds"].get<double>());
}

}  // namespace

void add_part_command(CommandLine& program, CommandContext& context) {
  add_job_command(
      program, context,
      {"part",
       "A part writes only into a directory of its own in PLAN, and at the end the file done.PART\n"
       "gets its name. So a part that was killed is simply started again, and a part that two\n"
       "machines make at once does no harm. A part of a pass reads its store and does not change "
       "it;\n"
       "passes of a program of your own are made by that program (plait/extend/parts.h).\n"
       "\n"
       "If the scratch memory of all threads does not fit --memory, a part of a subdivision takes\n"
       "fewer, and says so.\n"
       "\n"
       "Exit status 3: the disk, its room or another process was in the way; try again. With 1 or "
       "2\n"
       "the same command never ends well.\n"
       "\n"
       "Examples:\n"
       "  plait part molecule.plan 0\n"
       "  plait part statue.plan \"$SLURM_ARRAY_TASK_ID\" --list lost\n"
       "  plait part statue.plan \"$SLURM_ARRAY_TASK_ID\" --offset 1000",
       part_text,
       {},
       "plan"});
}

}  // namespace plait
