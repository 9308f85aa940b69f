#include "subdivision/run_size.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <string>

#include "base/text.h"
#include "io/machine.h"
#include "io/unpublished.h"
#include "job_rules.h"
#include "plait/error.h"
#include "schemes/table.h"
#include "store/left_overs.h"
#include "subdivision/planning.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Memory for each face of the base mesh while the job refines it, connects it and lays it out:
/// measured 160 to 180 bytes (peak_rss_bytes of `plait subdivide --backend memory --max-slot 12`),
/// of which 93 stay.
constexpr std::uint64_t kBaseMeshBytesPerFace = 180;
constexpr std::uint64_t kRunNormalBytes = 12;
constexpr std::uint64_t kExpectedCompression = 4;

/// 2^64 - 1 if the result does not fit, as in sum().
std::uint64_t product(std::uint64_t a, std::uint64_t b) {
  constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();
  return b != 0 && a > kMost / b ? kMost : a * b;
}
std::uint64_t sum(std::uint64_t a, std::uint64_t b) {
  return a + std::min(b, std::numeric_limits<std::uint64_t>::max() - a);
}

void refuse_size(SubdivisionPlan& plan, ErrorCode code, const std::string& what,
                 std::uint64_t needed, std::uint64_t found) {
  refuse(plan, "ignore-size", code,
         fmt::format("subdivide: {}: expected {}, found {}", what, format_bytes(needed),
                     format_bytes(found)));
}

std::uint64_t left_over_bytes(const std::filesystem::path& path) {
  const OutputName output(path);
  std::uint64_t bytes = 0;
  for (const LeftOver& left_over : find_left_overs(output.directory, output.name))
    if (!left_over.in_use) bytes += left_over.bytes;
  return bytes;
}

}  // namespace

SubdivisionSize size_of_run(const BaseMesh& input, const SubdivisionRequest& request,
                            const SubdivisionPlan& plan) {
  const int levels = plan.subdivide.levels, base_level = plan.base_level;
  const std::uint64_t position_bytes = 3 * component_bytes(plan.precision);
  const auto vertices = [&](int level) { return counts_at_level(input, level).vertices; };
  const auto born = [&](int first, int last) {
    return last < first ? 0 : vertices(last) - vertices(first - 1);
  };
  const int first = base_level + 1;
  const int done = plan.earlier ? plan.earlier->level : base_level;
  const bool has_normals = plan.earlier && plan.earlier->normals;
  const std::uint64_t normals = plan.subdivide.normals ? kRunNormalBytes : 0;

  SubdivisionSize size;
  size.level_bytes = product(born(first, levels), position_bytes + normals);
  // Rounded levels are copies; the exact ones stay until the commit.
  if (request.max_errors.of("position"))
    size.rounded_bytes = product(born(first, levels), position_bytes);
  if (request.max_errors.of("normal"))
    size.rounded_bytes = sum(size.rounded_bytes, product(born(first, levels), normals));
  size.longest_file_bytes = product(born(levels, levels), position_bytes);
  size.base_mesh_bytes = plan.piece_bytes != 0 ? plan.piece_bytes
                                               : product(counts_at_level(input, base_level).faces,
                                                         kBaseMeshBytesPerFace);
  if (!plan.keeps_store) return size;

  size.disk_bytes = product(born(done + 1, levels), position_bytes);
  if (!has_normals || done < levels)
    size.disk_bytes = sum(size.disk_bytes, product(born(first, levels), normals));
  // Level by level, Loop overwrites committed levels, and their old bytes stay until the next
  // commit. Limit positions are a second attribute until the commit.
  if (plan.commits_levels && done < levels && traits_of(plan.subdivide.scheme).moves_even)
    size.disk_bytes = sum(size.disk_bytes, product(born(first, levels - 1), position_bytes));
  if (plan.subdivide.limit && plan.subdivide.executor != ExecutorKind::kFused)
    size.disk_bytes = sum(size.disk_bytes, product(born(first, levels), position_bytes));
  size.disk_bytes = sum(size.disk_bytes, size.rounded_bytes);
  // What is left beside the levels of all faces, which are then removed: at most as much.
  if (request.max_distance) size.disk_bytes = sum(size.disk_bytes, size.level_bytes);
  return size;
}

void check_memory(SubdivisionPlan& plan, const BackendTraits& backend) {
  SubdivisionSize& size = plan.size;
  size.memory_bytes = sum(size.base_mesh_bytes,
                          backend.durable ? std::min(size.level_bytes, plan.store.budget_bytes)
                                          : sum(size.level_bytes, size.rounded_bytes));
  if (const auto refusal =
          lacks_memory(fmt::format("subdivide: memory for level {} ({} for the base mesh)",
                                   plan.subdivide.levels, format_bytes(size.base_mesh_bytes)),
                       size.memory_bytes))
    refuse(plan, refusal->option(), refusal->code(), refusal->what());
}

void check_disk(SubdivisionPlan& plan, const BackendTraits& backend,
                const std::filesystem::path& store) {
  if (!backend.durable) return;
  const std::uint64_t divisor = backend.compressed ? kExpectedCompression : 1;
  const std::string guess =
      backend.compressed
          ? fmt::format(", if compression reduces it to 1/{}, which is a guess", divisor)
          : "";
  const std::uint64_t removed = plan.commits_levels ? 0 : left_over_bytes(store);
  const std::uint64_t free_bytes = sum(free_disk_bytes(store), removed);
  if (const std::uint64_t needed = plan.size.disk_bytes / divisor; needed > free_bytes)
    refuse_size(plan, ErrorCode::kNoSpace,
                fmt::format("free space on the disk of {}{}", store.native(), guess), needed,
                free_bytes);
  const std::uint64_t longest = largest_file_bytes();
  if (const std::uint64_t needed = plan.size.longest_file_bytes / divisor; needed > longest)
    refuse_size(plan, ErrorCode::kNoSpace,
                fmt::format("the longest file that is allowed in {}{}", store.native(), guess),
                needed, longest);
}

PLAIT_END_NAMESPACE
