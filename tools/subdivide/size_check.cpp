#include "subdivide/size_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "arguments.h"
#include "plait/error.h"
#include "plait/machine.h"

namespace plait {
namespace {

/// Memory for each face of the base mesh while it is refined, connected and laid out: 160 to 180
/// bytes were measured (peak_rss_bytes of `plait subdivide --backend memory --max-slot 12`), 93
/// of them stay.
constexpr std::uint64_t kBaseMeshBytesPerFace = 180;
constexpr std::uint64_t kNormalBytes = 12;
constexpr std::uint64_t kExpectedCompression = 4;

/// 2^64 - 1 where it does not fit.
std::uint64_t product(std::uint64_t a, std::uint64_t b) {
  constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();
  return b != 0 && a > kMost / b ? kMost : a * b;
}
std::uint64_t sum(std::uint64_t a, std::uint64_t b) {
  return a + std::min(b, std::numeric_limits<std::uint64_t>::max() - a);
}

[[noreturn]] void refuse(ErrorCode code, const std::string& what, std::uint64_t needed,
                         std::uint64_t found) {
  throw Error(code, fmt::format("subdivide: {}: expected {}, found {}; --ignore-size goes on all "
                                "the same",
                                what, format_bytes(needed), format_bytes(found)));
}

}  // namespace

RunSize size_of_run(const BaseMesh& input, int base_level, const SubdivisionPlan& plan,
                    const Store* earlier) {
  const int levels = plan.subdivide.levels;
  const std::uint64_t position_bytes = plan.double_precision ? 24 : 12;
  const auto vertices = [&](int level) { return counts_at_level(input, level).vertices; };
  const auto born = [&](int first, int last) {
    return last < first ? 0 : vertices(last) - vertices(first - 1);
  };
  const int first = base_level + 1;
  const int done = earlier ? earlier->finest_level() : base_level;
  const std::uint64_t normals = plan.subdivide.normals ? kNormalBytes : 0;

  RunSize size;
  size.level_bytes = product(born(first, levels), position_bytes + normals);
  size.longest_file_bytes = product(born(levels, levels), position_bytes);
  size.base_mesh_bytes = product(counts_at_level(input, base_level).faces, kBaseMeshBytesPerFace);

  size.disk_bytes = product(born(done + 1, levels), position_bytes);
  if (!earlier || !earlier->has_attribute("normal") || done < levels)
    size.disk_bytes = sum(size.disk_bytes, product(born(first, levels), normals));
  // Level by level, a scheme that moves even vertices overwrites what is committed, and limit
  // positions are made beside those that they replace: both stay until the next commit.
  if (plan.commits_levels && done < levels && traits_of(plan.subdivide.scheme).moves_even)
    size.disk_bytes = sum(size.disk_bytes, product(born(first, levels - 1), position_bytes));
  if (plan.subdivide.limit && plan.subdivide.executor != ExecutorKind::kFused)
    size.disk_bytes = sum(size.disk_bytes, product(born(first, levels), position_bytes));
  return size;
}

void require_memory(const RunSize& size, const SubdivisionPlan& plan, BackendTraits backend) {
  std::uint64_t needed = size.base_mesh_bytes;
  needed = sum(needed, backend.durable ? std::min(size.level_bytes, plan.store.budget_bytes)
                                       : size.level_bytes);
  if (const std::uint64_t found = available_memory_bytes(); needed > found)
    refuse(ErrorCode::kOutOfMemory,
           fmt::format("memory for level {} ({} for the base mesh)", plan.subdivide.levels,
                       format_bytes(size.base_mesh_bytes)),
           needed, found);
}

void require_disk(const RunSize& size, const std::filesystem::path& path, BackendTraits backend) {
  if (!backend.durable) return;
  const std::uint64_t share = backend.compressed ? kExpectedCompression : 1;
  const std::string compressed =
      backend.compressed ? fmt::format(", a {}th of what is compressed", share) : "";
  if (const std::uint64_t found = free_disk_bytes(path); size.disk_bytes / share > found)
    refuse(ErrorCode::kNoSpace,
           fmt::format("free space on the disk of {}{}", path.native(), compressed),
           size.disk_bytes / share, found);
  if (const std::uint64_t found = largest_file_bytes(); size.longest_file_bytes / share > found)
    refuse(ErrorCode::kNoSpace,
           fmt::format("the longest file there may be in {}{}", path.native(), compressed),
           size.longest_file_bytes / share, found);
}

void require_budget(const Store& store, const SubdivideOptions& subdivision) {
  const std::uint64_t needed = subdivide_frame_bytes(store, subdivision);
  if (needed > store.options().budget_bytes)
    refuse(ErrorCode::kBudget,
           fmt::format("the budget (--memory) for level {} with layout {} and blocks of {}",
                       subdivision.levels, store.options().layout,
                       size_text(store.options().block_bytes)),
           needed, store.options().budget_bytes);
}

}  // namespace plait
