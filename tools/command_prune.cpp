// plait prune: copies a store, with fewer levels where fewer are enough.

#include <fmt/format.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "arguments.h"
#include "base/text.h"
#include "job_command.h"

namespace plait {
namespace {

std::string prune_text(const nlohmann::ordered_json& report) {
  const auto number = [&](const char* name) { return report[name].get<std::uint64_t>(); };
  std::string text =
      fmt::format("{}: {} of {} vertices ({:.3f}), {} of {}, {:.2f} s\n",
                  report["store"].get<std::string>(), number("vertices"), number("from_vertices"),
                  report["vertex_share"].get<double>(), format_bytes(number("stored_bytes")),
                  format_bytes(number("from_stored_bytes")), report["seconds"].get<double>());
  for (const auto& level : report["depths"])
    text += fmt::format("level {}: {} faces\n", level["level"].get<int>(),
                        level["faces"].get<std::uint64_t>());
  if (number("raised_faces") > 0)
    text +=
        fmt::format("{} faces made deeper, because of their neighbours\n", number("raised_faces"));
  if (report.contains("distance"))
    text += fmt::format("largest distance between the finest level and what is drawn: {:.6g}\n",
                        report["distance"].get<double>());
  return text;
}

}  // namespace

void add_prune_command(CommandLine& program, CommandContext& context) {
  add_job_command(
      program, context,
      {"prune",
       backend_help(context.backends) +
           "\n"
           "Every face keeps its levels up to a depth of its own. Vertices that are left have the\n"
           "bits that they have in INPUT: plait digest OUTPUT --against INPUT compares them. "
           "Where\n"
           "neighbours differ in depth, plait export draws the shallower one with the vertices of\n"
           "the deeper one on their side, so no gap is left; --max-distance counts with that.\n"
           "\n"
           "Works that need a level of all faces refuse the store: subdivide, pass, plan, publish. "
           "They\n"
           "work on a copy by plait convert --depth uniform.\n"
           "\n"
           "Examples:\n"
           "  plait prune surface.plait near.plait --max-distance 0.01%\n"
           "  plait prune surface.plait small.plait --vertices 1000000\n"
           "  plait prune surface.plait parts.plait --depth-by level --balance 0",
       prune_text});
}

}  // namespace plait
