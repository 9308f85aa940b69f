#include "plait/digest.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "execution/slot_hasher.h"
#include "execution/sweep/sweep_threads.h"
#include "paging/level_cursor.h"
#include "plait/error.h"
#include "plait/extend/store_access.h"
#include "plait/extend/sweep.h"
#include "plait/progress.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The accesses of each pass.
using Passes = std::vector<std::vector<LevelAccess>>;

/// One pass for each level of each attribute.
Passes passes_by_levels(const Store& store, int wanted_level) {
  Passes passes;
  for (AttributeId id = 0; id < store.attributes().size(); ++id)
    for (int level = store.base_level() + 1; level <= store.attributes()[id].finest_level; ++level)
      if (wanted_level == -1 || wanted_level == level)
        passes.push_back({{id, level, level, Access::kRead, Reach::kOwn}});
  return passes;
}

/// One pass for all levels, if some are decoded from others, and nothing otherwise. Then each block
/// is decoded once, and not again for each level and attribute that needs it.
std::optional<Passes> all_together(const Store& store, const Passes& by_levels) {
  std::vector<LevelAccess> together;
  for (const auto& accesses : by_levels)
    together.insert(together.end(), accesses.begin(), accesses.end());
  const bool coded = std::ranges::any_of(together, [&](const LevelAccess& access) {
    return needs_other_blocks(StoreAccess::level_file(store, access.attribute, access.first_level));
  });
  if (!coded || together.size() < 2) return std::nullopt;
  return Passes{std::move(together)};
}

/// Edges, or vertices, that are in memory at once where the base mesh is taken in pieces.
constexpr std::uint64_t kNumbersAtOnce = 1 << 15;

/// Of a store whose base mesh is taken in pieces.
Digest digest_of_base_in_runs(const Store& store) {
  SlotHasher hasher;
  std::vector<std::byte> records;
  for (AttributeId id = 0; id < store.attributes().size(); ++id) {
    const AttributeSchema& schema = store.attributes()[id].schema;
    const std::size_t record_bytes = schema.record_bytes();
    const std::uint64_t count = store.base().vertex_count();
    for (std::uint64_t first = 0; first < count; first += kNumbersAtOnce) {
      records.resize(std::min(kNumbersAtOnce, count - first) * record_bytes);
      StoreAccess::read_base_records(store, id, first * record_bytes, records);
      for (std::size_t at = 0; at * record_bytes < records.size(); ++at) {
        const auto vertex = static_cast<VertexId>(first + at);
        hasher.add(vertex, vertex, store.base_level(), schema.name,
                   std::span(records).subspan(at * record_bytes, record_bytes));
      }
    }
  }
  return hasher.sum();
}

/// Of the same, by one thread.
Digest digest_of_levels_in_runs(const Store& store, int wanted_level,
                                const ProgressCallback& progress) {
  SlotHasher hasher;
  const BaseMesh& base = store.base();
  const MeshPages& pages = *base.pages();
  const std::span<const Edge> edges = base.arrays().mesh.edges;
  std::uint64_t done = 0, total = 0;
  const auto each_level = [&](const auto& take) {
    for (AttributeId id = 0; id < store.attributes().size(); ++id)
      for (int level = store.base_level() + 1; level <= store.attributes()[id].finest_level;
           ++level)
        if (wanted_level == -1 || wanted_level == level) take(id, level);
  };
  each_level([&](AttributeId, int) { total += edges.size(); });
  each_level([&](AttributeId id, int level) {
    LevelCursor cursor(StoreAccess::open_session(store), StoreAccess::level_file(store, id, level));
    for (std::uint64_t first = 0; first < edges.size(); first += kNumbersAtOnce) {
      const std::uint64_t after = std::min<std::uint64_t>(first + kNumbersAtOnce, edges.size());
      pages.need_range(MeshArray::kEdges, first, after);
      for (auto edge = static_cast<EdgeId>(first); edge < after; ++edge)
        hasher.add(edges[edge].start, edges[edge].end, level, store.attributes()[id].schema.name,
                   cursor.slot(edge).bytes);
      pages.forget(MeshArray::kEdges, first, after);
      done += after - first;
      if (progress && !progress({"digest", done, total}))
        throw Error(ErrorCode::kCancelled, "digest: cancelled");
    }
  });
  return hasher.sum();
}

Digest digest_of_base(const Store& store) {
  if (StoreAccess::takes_pieces(store)) return digest_of_base_in_runs(store);
  SlotHasher hasher;
  for (AttributeId id = 0; id < store.attributes().size(); ++id) {
    const AttributeSchema& schema = store.attributes()[id].schema;
    const std::size_t record_bytes = schema.record_bytes();
    const std::span<const std::byte> records = store.base_bytes(id);
    const std::size_t vertex_count = store.base().vertex_count();
    const int base_level = store.base_level();
    for (VertexId vertex = 0; vertex < vertex_count; ++vertex)
      hasher.add(vertex, vertex, base_level, schema.name,
                 records.subspan(vertex * record_bytes, record_bytes));
  }
  return hasher.sum();
}

/// The sum of the hashes of all slots that the passes read.
Digest digest_of_levels(const Store& store, const Passes& passes, const DigestOptions& options,
                        int threads) {
  std::vector<SlotHasher> hashers(static_cast<std::size_t>(threads));
  const std::span<const Edge> edges = store.base().edges();
  const std::span<const AttributeInfo> attributes = store.attributes();
  for (std::size_t i = 0; i < passes.size(); ++i) {
    SweepPass pass{"digest", passes[i], {}};
    if (const LevelAccess& only = pass.accesses.front(); pass.accesses.size() == 1)
      pass.name = fmt::format("digest of '{}', level {}", attributes[only.attribute].schema.name,
                              only.first_level);
    pass.kernel = [&](const SweepView& view, EdgeId edge, int worker) {
      for (std::size_t at = 0; at < pass.accesses.size(); ++at) {
        const LevelAccess& access = pass.accesses[at];
        const LocatedSlot slot = view.slot(at, access.first_level, edge);
        if (slot.shape == SlotShape::kAbsent) continue;
        hashers[static_cast<std::size_t>(worker)].add(
            edges[edge].start, edges[edge].end, access.first_level,
            attributes[access.attribute].schema.name, slot.bytes);
      }
    };
    SweepOptions sweep_options;
    sweep_options.threads = threads;
    sweep_options.takes_depths = true;
    if (options.progress)
      sweep_options.progress = [&](const Progress& now) {
        return options.progress(
            {"digest", i * edges.size() + now.done, passes.size() * edges.size()});
      };
    sweep(store, pass, sweep_options);
  }
  for (std::size_t i = 1; i < hashers.size(); ++i) hashers[0].add(hashers[i].sum());
  return hashers[0].sum();
}

}  // namespace

std::string Digest::to_string() const { return fmt::format("{:016x}{:016x}", high, low); }

Digest digest(const Store& store, const DigestOptions& options) try {
  if (options.level != -1 &&
      (options.level < store.base_level() || options.level > store.finest_level()))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("digest level {}: expected {} to {}", options.level, store.base_level(),
                            store.finest_level()));
  const int threads = thread_count(options.threads, "digest");
  for (AttributeId id = 0; id < store.attributes().size(); ++id)
    for (int level = store.base_level(); level <= store.attributes()[id].finest_level; ++level)
      if (options.level == -1 || options.level == level)
        StoreAccess::check_readable(store, id, level);
  const StorePass under_way(store);
  SlotHasher sum;
  if (options.level == -1 || options.level == store.base_level()) sum.add(digest_of_base(store));
  if (StoreAccess::takes_pieces(store)) {
    sum.add(digest_of_levels_in_runs(store, options.level, options.progress));
    return sum.sum();
  }
  const Passes by_levels = passes_by_levels(store, options.level);
  const auto begin = [&](const Passes& passes) {
    int least = threads;
    for (const auto& accesses : passes)
      // The pass only reads.
      least =
          std::min(least, sweep_threads(const_cast<Store&>(store), {"digest", accesses}, threads));
    if (options.begins) options.begins(least);
  };
  if (const auto together = all_together(store, by_levels)) {
    try {
      begin(*together);
      sum.add(digest_of_levels(store, *together, options, threads));
      return sum.sum();
    } catch (const Error& error) {
      // That number of blocks at once, each with its context, is more than the budget holds.
      if (error.code() != ErrorCode::kBudget) throw;
    }
  }
  begin(by_levels);
  sum.add(digest_of_levels(store, by_levels, options, threads));
  return sum.sum();
} catch (const std::bad_alloc&) {
  throw out_of_memory("digest of " + store.path().native());
}

PLAIT_END_NAMESPACE
