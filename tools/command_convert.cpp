// plait convert: copies a store into another backend, compression or block size.

#include <fmt/format.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "arguments.h"
#include "base/text.h"
#include "job_command.h"
#include "report_text.h"

namespace plait {
namespace {

std::string convert_text(const nlohmann::ordered_json& report) {
  const auto word = [&](const char* name) { return report[name].get<std::string>(); };
  const auto bytes = [&](const char* name) {
    return format_bytes(report[name].get<std::uint64_t>());
  };
  std::string text = fmt::format(
      "{}: {} by backend {} ({}), was {} by {} ({:.2f} to 1), {:.2f} s\n", word("store"),
      bytes("stored_bytes"), word("backend"), word("backend_reason"), bytes("from_stored_bytes"),
      word("from_backend"), report["ratio"].get<double>(), report["seconds"].get<double>());
  for (const auto& made : report["made_blocks"]) text += made_blocks_text(made);
  if (report.contains("max_error"))
    for (const auto& [name, rounding] : report["max_error"].items())
      text += fmt::format("{}: {}\n", name, rounding_text(rounding));
  if (report.contains("left_out_max_error"))
    for (const auto& [name, rounding] : report["left_out_max_error"].items())
      text += fmt::format(
          "{}: the record of an earlier rounding is not taken along, because filled vertices are "
          "not rounded ({})\n",
          name, rounding_text(rounding));
  if (report.contains("digest"))
    text += fmt::format("read back: digest {}, {}\n", word("digest"),
                        report.contains("max_error") ? "every record within its bound of the source"
                        : report.value("filled_vertices", std::uint64_t{0}) > 0
                            ? "with every record of the source"
                            : "equal to that of the source");
  return text;
}

}  // namespace

void add_convert_command(CommandLine& program, CommandContext& context) {
  add_job_command(
      program, context,
      {"convert",
       backend_help(context.backends) + compression_help() +
           "\n"
           "The copy is like INPUT in everything that no option changes.\n"
           "\n"
           "The presets default and small make normals again from the positions, instead of "
           "storing\n"
           "them, wherever that gives the same bits: plait info counts such blocks as predicted.\n"
           "\n" +
           max_error_help() +
           " --verify then compares\n"
           "every record with INPUT. --max-error implies --compress default.\n"
           "\n"
           "A store whose faces have depths of their own (plait prune) cannot be subdivided and "
           "the\n"
           "like; its copy with --depth uniform can. The vertices that it lacks are put in the\n"
           "middle between their parents, and their number is said.\n"
           "\n"
           "Examples:\n"
           "  plait convert surface.plait small.plait --compress small\n"
           "  plait convert surface.plait mixed.plait --compress default --compress @5-=fast\n"
           "  plait convert surface.plait lossy.plait --max-error 1e-6rel --max-error normal=1e-3\n"
           "  plait convert small.plait fast.plait --backend mmap --block 256KiB --verify\n"
           "  plait convert near.plait all.plait --depth uniform",
       convert_text});
}

}  // namespace plait
