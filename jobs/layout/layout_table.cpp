// The job "layout".
#include <fmt/format.h>

#include <cstdint>
#include <filesystem>

#include "base/text.h"
#include "io/unpublished.h"
#include "job.h"
#include "job_rules.h"
#include "layout/base_directory.h"
#include "layout/lay_out_in_files.h"
#include "plait/error.h"
#include "store/new_output.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;
/// The program and buffers of files, beside the sorts; and the least for the sorts.
constexpr std::uint64_t kOwnBytes = 64 * kMiB, kLeastSortBytes = 32 * kMiB;

struct LayoutArguments {
  std::filesystem::path mesh, out;
  std::uint64_t memory = std::uint64_t{2} << 30;
};

JobReport run_layout(const LayoutArguments& arguments, const JobCall& call) {
  const JobWatch& watch = call.watch;
  if (arguments.memory < kOwnBytes + kLeastSortBytes)
    throw JobError(
        ErrorCode::kBudget,
        fmt::format("lay out {}: expected at least {} of memory, found {}", arguments.mesh.native(),
                    format_bytes(kOwnBytes + kLeastSortBytes), format_bytes(arguments.memory)),
        "memory");
  FileLayoutRequest request{arguments.mesh, {.bytes = arguments.memory - kOwnBytes}};
  std::uint64_t need = 0;
  request.begin = [&](std::uint64_t vertices, std::uint64_t faces) {
    need = disk_need(vertices, faces, request.memory);
    const auto line = disk_for_sorts(fmt::format("lay out {}", arguments.mesh.native()),
                                     OutputName(arguments.out).path, need);
    if (line && watch.warn) watch.warn(*line);
  };
  request.progress = watch.progress;
  if (watch.step) watch.step("layout");
  if (watch.before_files) watch.before_files();
  FileLayoutResult result;
  const std::filesystem::path made = make_new_directory(
      arguments.out, watch.warn, remove_base_directory, [&](const Directory& directory) {
        result = lay_out_in_files(request, directory);
        write_base_directory(directory, result.counts, result.base_mesh);
      });
  if (watch.warn)
    for (const std::string& warning : result.warnings) watch.warn(warning);
  return {{"mesh", arguments.mesh.string()},
          {"base", made.string()},
          {"vertices", result.counts.vertices},
          {"edges", result.counts.edges},
          {"faces", result.counts.faces},
          {"border_edges", result.counts.border_edges},
          {"layout", to_string(kLayoutOfBaseDirectory)},
          {"base_mesh_bytes", result.base_mesh.bytes},
          {"memory_bytes", arguments.memory},
          {"disk_bytes", need},
          {"merged_runs", result.merged_runs}};
}

}  // namespace

Job layout_job() {
  JobTable<LayoutArguments> table(
      "layout", "Put a mesh larger than memory in the order of a store, for subdivide and plan");
  table.path("mesh", &LayoutArguments::mesh, "PLY of triangles, also .gz and .zst")
      .at(0)
      .required();
  table.output("out", &LayoutArguments::out, "The directory to make: NAME.base").at(1).required();
  table.bytes("memory", &LayoutArguments::memory, "Memory of the whole process");
  return table.run(run_layout);
}

PLAIT_END_NAMESPACE
