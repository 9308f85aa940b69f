// plait pass, and displace: smooths or moves the vertices of a store, or makes normals anew.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "arguments.h"
#include "base/text.h"
#include "job_command.h"
#include "plait/job.h"

namespace plait {
namespace {

std::string pass_text(const nlohmann::ordered_json& report) {
  std::string text =
      fmt::format("{}: {}", report["store"].get<std::string>(), report["kind"].get<std::string>());
  if (report.contains("factor"))
    text += fmt::format(" by {:g} of the way", report["factor"].get<double>());
  if (report.contains("amplitude"))
    text += fmt::format(" of {:g} diagonals", report["amplitude"].get<double>());
  if (report.contains("wavelengths")) {
    const auto waves = report["wavelengths"].get<std::vector<double>>();
    text += fmt::format(", {} octaves of waves from {:.4g} to {:.4g}", waves.size(), waves.front(),
                        waves.back());
  }
  if (report.contains("seed"))
    text += fmt::format(", seed {}", report["seed"].get<std::uint64_t>());
  if (report.contains("largest_move"))
    text += fmt::format("; the longest way is {:.4g}", report["largest_move"].get<double>());
  if (const std::uint64_t rounded = report.value("rounded", std::uint64_t{0}); rounded > 0)
    text += fmt::format(" ({} vertices go another way than asked: rounding)", rounded);
  if (report.contains("diagonal"))
    text += fmt::format(", the diagonal {:.4g}", report["diagonal"].get<double>());
  return text + fmt::format("; new: {}; version {}, {}, {:.2f} s\n",
                            fmt::join(report["made"].get<std::vector<std::string>>(), ", "),
                            report["version"].get<std::uint64_t>(),
                            format_bytes(report["stored_bytes"].get<std::uint64_t>()),
                            report["seconds"].get<double>());
}

/// The job "pass" as a command that copies: STORE OUT --kind noise or fractal.
JobDescription displace_description() {
  JobDescription displace = find_job("pass");
  displace.name = "displace";
  displace.summary = "Copy a store and move its vertices: pass noise or fractal";
  std::erase_if(displace.options, [](const JobOption& option) { return option.name == "factor"; });
  for (JobOption& option : displace.options) {
    if (option.name == "kind") {
      option.position = -1;
      option.required = false;
      option.choices = {"noise", "fractal"};
      option.default_text = "noise";
    }
    if (option.name == "out") {
      option.position = 1;
      option.required = true;
      option.help = "The store to make";
    }
  }
  // Positions in the order of the command line.
  std::ranges::stable_sort(displace.options, {},
                           [](const JobOption& option) { return option.position < 0; });
  return displace;
}

}  // namespace

void add_pass_commands(CommandLine& program, CommandContext& context) {
  const std::string kinds =
      "\n"
      "noise moves each coordinate by up to the amplitude. fractal moves vertices along the\n"
      "normals, in waves from an eighth of the diagonal down to four mean edges of the finest\n"
      "level: the longest waves have the amplitude, the next ones, half as long, 0.45 of it.\n";
  const std::string same =
      "If STORE has normals, they are made anew from the new positions. The same seed gives the\n"
      "same surface for every backend, layout and number of threads. Everything else stays.\n"
      "\n"
      "Examples:\n";
  const std::string choices = backend_help(context.backends) + compression_help();
  add_job_command(
      program, context,
      {.job = "pass",
       .footer =
           choices + kinds +
           "smooth moves each vertex by the factor towards the mean of its neighbours at the\n"
           "finest level, one of a border towards the mean of its two neighbours there.\n"
           "normals makes unit normals. Without OUT, the commit makes the next version of\n"
           "STORE, and until then readers and a killed run have the one before.\n" +
           same +
           "  plait pass surface.plait smooth\n"
           "  plait pass surface.plait smooth softer.plait --factor 0.25\n"
           "  plait pass surface.plait fractal rocks.plait --amplitude 0.01 --seed 7",
       .text = pass_text});
  add_job_command(
      program, context,
      {.job = "pass",
       .footer =
           choices + kinds + same +
           "  plait displace surface.plait scanned.plait --amplitude 3e-7\n"
           "  plait displace surface.plait rocks.plait --kind fractal --amplitude 0.01 --seed 7",
       .text = pass_text,
       .described = displace_description(),
       .unless_given = {{"kind", "noise"}}});
}

}  // namespace plait
