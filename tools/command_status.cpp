// plait status: how far a plan is.

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cstdint>
#include <ctime>
#include <nlohmann/json.hpp>
#include <string>

#include "base/text.h"
#include "job_command.h"

namespace plait {
namespace {

using Json = nlohmann::ordered_json;

std::string time_text(std::uint64_t seconds) {
  return fmt::format("{:%Y-%m-%d %H:%M:%S} UTC", fmt::gmtime(static_cast<std::time_t>(seconds)));
}

std::string duration_text(double seconds) {
  if (seconds < 120) return fmt::format("{:.0f} s", seconds);
  if (seconds < 7200) return fmt::format("{:.0f} min", seconds / 60);
  return fmt::format("{:.1f} h", seconds / 3600);
}

std::string status_text(const Json& report) {
  std::string text;
  for (const Json& part : report["parts"]) {
    const auto state = part["state"].get<std::string>();
    if (state == "done") continue;
    text += fmt::format("part {}: {} on {} since {}, changed {}\n",
                        part["part"].get<std::uint32_t>(), state, part["host"].get<std::string>(),
                        time_text(part["begun"].get<std::uint64_t>()),
                        time_text(part["changed"].get<std::uint64_t>()));
  }
  const auto count = [&](const char* name) { return report[name].get<std::uint64_t>(); };
  if (const auto array = report["array"].get<std::string>(); !array.empty())
    text += fmt::format("neither done nor running: {}\n", array);
  text += fmt::format("{}: {} of {} parts done, {} running, {} lost, {} not begun",
                      report["plan"].get<std::string>(), count("done"), count("part_count"),
                      count("running"), count("lost"), count("waiting"));
  if (count("done") > 0)
    text += fmt::format(
        ", {}/s and process",
        format_bytes(static_cast<std::uint64_t>(report["bytes_per_second"].get<double>())));
  if (report.contains("seconds_left") && count("done") < count("part_count"))
    text += fmt::format(", about {} left", duration_text(report["seconds_left"].get<double>()));
  return text + "\n";
}

}  // namespace

void add_status_command(CommandLine& program, CommandContext& context) {
  add_job_command(
      program, context,
      {"status",
       "A part is running if a process of this machine makes it, or if one of another machine has\n"
       "begun it: whether that one still runs, its last change tells. It is lost if its process "
       "on\n"
       "this machine was killed. The time left is for as many processes as run now. --json lists\n"
       "for each part its host, since when, and of a done one the user, its seconds, those of\n"
       "processors, and its memory.\n"
       "\n"
       "Examples:\n"
       "  plait status statue.plan\n"
       "  plait status statue.plan --json",
       status_text});
}

}  // namespace plait
