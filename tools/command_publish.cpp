// plait publish: makes a copy of a store that browsers can show from any web server.

#include <fmt/format.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "base/text.h"
#include "job_command.h"

namespace plait {
namespace {

std::string publish_text(const nlohmann::ordered_json& report) {
  const auto& first = report["first_view"];
  return fmt::format(
      "{}: {} faces, {} stored; the first view takes {} request{} and {} (view {}, page {})\n",
      report["store"].get<std::string>(), format_count(report["faces"].get<std::uint64_t>()),
      format_bytes(report["stored_bytes"].get<std::uint64_t>()), first["requests"].get<int>(),
      first["requests"].get<int>() == 1 ? "" : "s",
      format_bytes(first["bytes"].get<std::uint64_t>()),
      format_bytes(report["view_bytes"].get<std::uint64_t>()),
      format_bytes(report["page_bytes"].get<std::uint64_t>()));
}

}  // namespace

void add_publish_command(CommandLine& program, CommandContext& context) {
  add_job_command(
      program, context,
      {.job = "publish",
       .footer =
           "The copy has its records raw, because browsers read them by their places. Beside them\n"
           "are the file view, which one request brings for the first picture, the bounds, and "
           "with\n"
           "--page the page itself, as index.html. The copy is a store as any other.\n"
           "\n"
           "Examples:\n"
           "  plait publish surface.plait www/surface --page\n"
           "  plait publish surface.plait www/surface --force --json",
       .text = publish_text});
}

}  // namespace plait
