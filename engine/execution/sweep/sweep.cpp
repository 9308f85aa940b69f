#include "plait/extend/sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <optional>
#include <utility>
#include <vector>

#include "execution/pin_needs.h"
#include "execution/sweep/sweep_threads.h"
#include "execution/sweep/sweep_window.h"
#include "execution/sweep/sweep_workers.h"
#include "plait/error.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/store_access.h"
#include "plait/layout.h"
#include "plait/progress.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

namespace {

/// Whether the pass writes to a level.
bool writes(const SweepPass& pass) {
  return std::ranges::any_of(pass.accesses, [](const LevelAccess& access) {
    return access.access != Access::kRead && access.first_level <= access.last_level;
  });
}

void check_accesses(const Store& store, const SweepPass& pass) {
  std::vector<const LevelFile*> written;
  for (const LevelAccess& access : pass.accesses) {
    if (access.last_level < access.first_level) continue;
    const bool known = access.attribute < store.attributes().size();
    if (!known || access.first_level <= store.base_level() ||
        access.last_level > store.attributes()[access.attribute].finest_level)
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("sweep '{}': attribute {} has no levels {} to {}", pass.name,
                              access.attribute, access.first_level, access.last_level));
    if (access.access != Access::kOverwrite)
      for (int level = access.first_level; level <= access.last_level; ++level)
        StoreAccess::check_readable(store, access.attribute, level, true);
    if (access.access == Access::kRead) continue;
    if (access.reach != Reach::kOwn)
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("sweep '{}': writes beyond the edge's own slot", pass.name));
    for (int level = access.first_level; level <= access.last_level; ++level) {
      written.push_back(&StoreAccess::level_file(store, access.attribute, level));
      check_not_fixed(*written.back());
    }
  }
  check_not_encoded_from_each_other(written);
}

}  // namespace

std::uint64_t sweep_window_bytes(Store& store, const SweepPass& pass, int threads) {
  threads = thread_count(threads, fmt::format("sweep '{}'", pass.name));
  check_accesses(store, pass);
  std::vector<AccessedGeometries> accesses;
  for (const LevelAccess& access : pass.accesses) {
    accesses.push_back({{}, access.reach});
    for (int number = access.first_level; number <= access.last_level; ++number)
      accesses.back().levels.push_back(
          StoreAccess::level_file(store, access.attribute, number).geometry);
  }
  return window_needs(store, std::move(accesses), threads);
}

int sweep_threads(Store& store, const SweepPass& pass, int threads) {
  threads = thread_count(threads, fmt::format("sweep '{}'", pass.name));
  const std::uint64_t budget = StoreAccess::pager(store).budget_bytes();
  // The window of more threads grows by powers of two (chunk_edges()).
  while (threads > 1 && sweep_window_bytes(store, pass, threads) > budget)
    threads = static_cast<int>(std::bit_floor(static_cast<unsigned>(threads - 1)));
  return threads;
}

void sweep(Store& store, const SweepPass& pass, const SweepOptions& options) try {
  if (!options.takes_depths)
    for (const LevelAccess& access : pass.accesses)
      if (access.first_level <= access.last_level)
        StoreAccess::refuse_depths(store, fmt::format("sweep '{}' over", pass.name),
                                   access.last_level);
  const int threads = sweep_threads(store, pass, options.threads);
  const std::uint64_t needed_bytes = sweep_window_bytes(store, pass, threads);
  if (needed_bytes > StoreAccess::pager(store).budget_bytes())
    throw Error(
        ErrorCode::kBudget,
        fmt::format("sweep '{}': the window needs {} bytes of frames and the budget has {}; "
                    "the layout '{}' has stencils that span {} edges, and a block holds "
                    "{} bytes: raise the budget, take smaller blocks or another layout",
                    pass.name, needed_bytes, StoreAccess::pager(store).budget_bytes(),
                    store.provenance().layout, measure_spans(store.base()).loop.span,
                    store.options().block_bytes));
  std::optional<StorePass> under_way;
  if (writes(pass))
    under_way.emplace(store, fmt::format("sweep '{}' of", pass.name));
  else
    under_way.emplace(std::as_const(store));
  SweepWindow window(store, pass);
  const EdgeRange edges = StoreAccess::edges(store);
  // The window moves by whole runs of blocks, so that a run is one transfer and the workers seldom
  // wait for each other, unless that takes more than a quarter of the budget. A window over twice
  // the edges has at most twice the blocks.
  const EdgeId run_edges = window.run_edges(threads);
  EdgeId chunk = window.chunk_edges(threads);
  SessionOptions session;
  session.window_bytes = needed_bytes;
  while (2 * chunk <= run_edges &&
         2 * session.window_bytes <= StoreAccess::pager(store).budget_bytes() / 4) {
    chunk *= 2;
    session.window_bytes *= 2;
  }
  window.open(session);
  if (options.begins) options.begins();
  UnfinishedLevels written;
  for (const LevelAccess& access : pass.accesses)
    for (int level = access.first_level; level <= access.last_level; ++level)
      written.add(StoreAccess::level_file(store, access.attribute, level), access.access);

  SweepWorkers workers(store.options().parallel_for, pass, threads);
  const auto chunk_end = [&](EdgeId first) { return first + std::min(chunk, edges.after - first); };
  window.plan(edges.first, chunk_end(edges.first));
  window.look_ahead(edges.first, run_edges);
  for (EdgeId first = edges.first; first < edges.after;) {
    const EdgeId after = chunk_end(first);
    window.advance();
    if (after < edges.after) {
      window.plan(after, chunk_end(after));
      window.look_ahead(after, run_edges);
    }
    workers.run(window.view(), first, after);
    if (pass.stretch_done) pass.stretch_done();
    first = after;
    if (options.progress &&
        !options.progress({pass.name, first - edges.first, edges.after - edges.first}))
      throw Error(ErrorCode::kCancelled, fmt::format("sweep '{}': cancelled", pass.name));
  }
  written.finish();
} catch (const std::bad_alloc&) {
  throw out_of_memory("sweep " + pass.name);
}

void sweep(const Store& store, const SweepPass& pass, const SweepOptions& options) {
  if (writes(pass))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("sweep '{}': expected a pass that only reads, because the store is "
                            "const",
                            pass.name));
  sweep(const_cast<Store&>(store), pass, options);  // which then changes nothing
}

PLAIT_END_NAMESPACE
