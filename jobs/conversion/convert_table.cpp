// The job "convert".
#include <fmt/format.h>

#include "conversion/conversion_job.h"
#include "job.h"
#include "job_rules.h"
#include "report_json.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

struct ConvertArguments : ConversionRequest {
  std::vector<std::string> compress, max_error;
};

JobReport run_convert(ConvertArguments& arguments, const JobCall& call) {
  arguments.compression = compression_of(arguments.compress);
  arguments.max_errors = error_bounds_of(arguments.max_error);
  arguments.parallel_for = call.parallel_for;
  const ConversionResult done = convert(arguments, call.open_backends, call.backends, call.watch);
  JobReport report = {{"from", arguments.from.string()},
                      {"store", done.store.string()},
                      {"backend", done.options.backend},
                      {"backend_reason", done.backend_reason},
                      {"block_bytes", done.options.block_bytes},
                      {"from_backend", done.from_backend},
                      {"from_stored_bytes", done.from_stored_bytes},
                      {"stored_bytes", done.stored_bytes},
                      {"ratio", static_cast<double>(done.from_stored_bytes) /
                                    static_cast<double>(done.stored_bytes)},
                      {"made_blocks", made_blocks_json(done.store, call.backends)}};
  for (const auto& [name, rounding] : done.roundings)
    report["max_error"][name] = rounding_json(rounding);
  if (arguments.uniform) {
    report["vertices"] = done.vertices;
    report["filled_vertices"] = done.filled_vertices;
    report["left_out_max_error"] = JobReport::object();
    for (const auto& [name, rounding] : done.left_out_roundings)
      report["left_out_max_error"][name] = rounding_json(rounding);
    if (done.filled_vertices > 0 && call.watch.warn)
      call.watch.warn(fmt::format(
          "convert {}: faces had depths of their own, so {} of {} vertices of the copy are filled "
          "by the midpoint rule; plait digest {} --against {} compares the others",
          arguments.from.native(), done.filled_vertices, done.vertices, arguments.from.native(),
          done.store.native()));
  }
  if (!done.digest.empty()) report["digest"] = done.digest;
  return report;
}

}  // namespace

Job convert_job() {
  JobTable<ConvertArguments> table("convert",
                                   "Copy a store into another backend, compression or block size");
  table.path("input", &ConvertArguments::from, "The store to copy").at(0).required();
  table.output("output", &ConvertArguments::to, "The store to make").at(1).required();
  table.text("backend", &ConvertArguments::backend,
             "The backend of the copy (see below); auto: chosen by its size; default: as in INPUT");
  table.compress(&ConvertArguments::compress);
  table.max_error(&ConvertArguments::max_error);
  table
      .choice(
          "depth", {"own", "uniform"},
          [](ConvertArguments& arguments, const std::string& name) {
            arguments.uniform = name == "uniform";
          },
          "Depths of faces: those of INPUT, or all levels for each face, where missing vertices "
          "are filled by the midpoint rule")
      .by_default("own");
  table.bytes("block", &ConvertArguments::block_bytes, std::string(kBlockOfCopyHelp));
  table.flag("no-index", &ConvertArguments::no_index, std::string(kNoIndexHelp));
  table.bytes(
      "memory", &ConvertArguments::budget_bytes,
      "Budget for blocks in memory; half of it for the source, or less where it needs less");
  table.threads(&ConvertArguments::threads, "Threads of --verify");
  table.flag("verify", &ConvertArguments::verify,
             "Read the copy back from the disk and compare it with INPUT");
  table.force(&ConvertArguments::existing);
  return table.run(run_convert);
}

PLAIT_END_NAMESPACE
