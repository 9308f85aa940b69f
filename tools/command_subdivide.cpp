// plait subdivide: refines a mesh and makes a store of it.

#include <fmt/format.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "argument_text.h"
#include "arguments.h"
#include "base/text.h"
#include "job_command.h"
#include "report_text.h"

namespace plait {
namespace {

using Json = nlohmann::ordered_json;

std::string word(const Json& json) { return json.get<std::string>(); }
std::string count(const Json& json) { return format_count(json.get<std::uint64_t>()); }
std::string bytes(const Json& json) { return format_bytes(json.get<std::uint64_t>()); }

std::string mesh_text(const Json& mesh) {
  return fmt::format("{} vertices, {} edges ({} border), {} faces", count(mesh["vertices"]),
                     count(mesh["edges"]), count(mesh["border_edges"]), count(mesh["faces"]));
}

std::string surface_text(const Json& report) {
  std::string text = fmt::format("input      {}\n", mesh_text(report["input"]));
  if (const int base_level = report["base_level"].get<int>(); base_level > 0)
    text += fmt::format("base       {}, refined {} times in memory\n", mesh_text(report["base"]),
                        base_level);
  text +=
      fmt::format("level {:<2}   {} vertices, {} edges, {} faces{}\n", report["levels"].get<int>(),
                  count(report["vertices"]), count(report["edges"]), count(report["faces"]),
                  report.contains("depths") ? ", as it is drawn" : "");
  if (report.contains("depths"))
    text += fmt::format(
        "depths     leave {} of {} vertices and {} of {} faces, at most {:.6g} from all, in {:.2f} "
        "s\n",
        count(report["vertices"]), count(report["from_vertices"]), count(report["faces"]),
        count(report["from_faces"]), report["distance"].get<double>(),
        report["prune_seconds"].get<double>());
  const int threads = report["threads"].get<int>();
  text +=
      fmt::format("method     {}{}{}, {}, executor {}, {} thread{}\n", word(report["scheme"]),
                  report["limit"].get<bool>() ? " with limit positions" : "",
                  report["normals"].get<bool>() ? " with normals" : "", word(report["precision"]),
                  word(report["executor"]), threads, threads == 1 ? "" : "s");
  if (report["span"].is_null())
    return text + fmt::format("layout     {}, base mesh in pieces of up to {}\n",
                              word(report["layout"]), bytes(report["piece_bytes"]));
  return text + fmt::format("layout     {}, span {} edges\n", word(report["layout"]),
                            count(report["span"]));
}

/// The digest, if there is one, is the last line.
std::string subdivide_text(const Json& report) {
  const auto seconds = [&](const char* name) { return report[name].get<double>(); };
  const bool has_digest = report.contains("digest");
  std::string text;
  for (const Json& made : report["made_blocks"]) text += made_blocks_text(made);
  text += surface_text(report);
  text += fmt::format(
      "time       {:.2f} s: import {:.2f}, layout {:.2f}, refine {:.2f}, commit {:.2f}{}; {:.1f} "
      "ns "
      "per vertex; {:.2f} s of processor time\n",
      seconds("seconds"), seconds("import_seconds"), seconds("layout_seconds"),
      seconds("refine_seconds"), seconds("commit_seconds"),
      has_digest ? fmt::format(", digest {:.2f}", seconds("digest_seconds")) : "",
      seconds("ns_per_vertex"), seconds("cpu_seconds"));
  text += fmt::format("moved      {} written, {} read, {} stored by backend {}\n",
                      bytes(report["bytes_written"]), bytes(report["bytes_read"]),
                      bytes(report["stored_bytes"]), word(report["backend"]));
  text +=
      fmt::format("backend    {}: {}\n", word(report["backend"]), word(report["backend_reason"]));
  text += fmt::format("memory     {} at most; budget {}, base mesh {}\n",
                      bytes(report["peak_rss_bytes"]), bytes(report["budget_bytes"]),
                      bytes(report["base_mesh_bytes"]));
  if (report.contains("max_error"))
    for (const auto& [name, rounding] : report["max_error"].items())
      text += fmt::format("rounded    {}: {}\n", name, rounding_text(rounding));
  if (has_digest) text += fmt::format("digest     {}\n", word(report["digest"]));
  return text;
}

}  // namespace

void add_subdivide_command(CommandLine& program, CommandContext& context) {
  add_job_command(
      program, context,
      {"subdivide",
       backend_help(context.backends) + compression_help() +
           "  auto         uring for a store that is large compared with the available memory, if "
           "the\n"
           "               kernel and the file system support it; otherwise pread. The files are "
           "the\n"
           "               same.\n"
           "\n" +
           max_error_help() +
           " Until the\n"
           "levels are complete, exact and rounded ones take disk space. --max-error implies\n"
           "--compress default.\n"
           "\n"
           "--resume takes scheme, precision, backend, pipelines, layout, block size and base "
           "mesh\n"
           "from the store, and refuses options that differ. Normals fit only the level that they "
           "were\n"
           "computed for. So a store with normals needs --normals again, and gets the new levels "
           "and\n"
           "new normals in one commit.\n"
           "Before it starts, the command compares the memory and the disk space that it needs "
           "with "
           "the\n"
           "budget, the available memory and the free disk space, and refuses to start if one of "
           "them "
           "is\n"
           "too small (--ignore-size starts anyway, but not with too small a budget).\n"
           "`seconds` is the whole time of the job.\n"
           "--max-distance makes all levels and then, beside them, what plait prune leaves of "
           "them;\n"
           "only that gets the name OUTPUT.\n"
           "\n"
           "Examples:\n"
           "  plait subdivide molecule.ply molecule.plait --levels 5 --normals\n"
           "  plait subdivide molecule.ply near.plait --levels 5 --max-distance 0.01%\n"
           "  plait subdivide bunny.ply bunny.plait --levels 4 --compress fast --memory 64MiB\n"
           "  plait subdivide bunny.ply lossy.plait --levels 6 --max-error 1e-6rel --verify\n"
           "  plait subdivide bunny.ply mixed.plait --levels 6 --compress small --compress "
           "@6=fast\n"
           "  plait subdivide spot.ply --levels 3 --backend memory --digest --json\n"
           "  plait subdivide statue.ply statue.plait --levels 6 --resume    again after a "
           "crash\n"
           "  plait subdivide statue.ply statue.plait --levels 7 --resume    one level more",
       subdivide_text});
}

}  // namespace plait
