#include "plait/sweep.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <optional>

#include "execution/sweep/sweep_window.h"
#include "plait/edge_index.h"
#include "plait/error.h"
#include "plait/layout.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

namespace {

void check_accesses(const Store& store, const SweepPass& pass) {
  for (const LevelAccess& access : pass.accesses) {
    if (access.last_level < access.first_level) continue;
    const bool known = access.attribute < store.attributes().size();
    if (!known || access.first_level <= store.base_level() ||
        access.last_level > store.attributes()[access.attribute].finest_level)
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("sweep '{}': attribute {} has no levels {} to {}", pass.name,
                              access.attribute, access.first_level, access.last_level));
    if (access.access == Access::kRead) continue;
    if (access.reach != Reach::kOwn)
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("sweep '{}': writes beyond the edge's own slot", pass.name));
    if (!store.level_file(access.attribute, access.first_level).writable)
      throw Error(ErrorCode::kBadState,
                  fmt::format("sweep '{}': writes to {}, which was opened for reading", pass.name,
                              store.path().native()));
  }
}

std::uint64_t window_bytes_of(SweepWindow& window, EdgeId edge_count, EdgeId chunk) {
  std::uint64_t most = 0;
  for (EdgeId first = 0; first < edge_count; first += std::min(chunk, edge_count - first)) {
    window.plan(first, first + std::min(chunk, edge_count - first));
    most = std::max(most, window.planned_bytes());
  }
  return most;
}

}  // namespace

std::uint64_t sweep_window_bytes(Store& store, const SweepPass& pass, int threads) {
  check_accesses(store, pass);
  SweepWindow window(store, pass);
  return window_bytes_of(window, static_cast<EdgeId>(store.base().edge_count()),
                         window.chunk_edges(threads));
}

void sweep(Store& store, const SweepPass& pass, const SweepOptions& options) {
  if (options.threads < 1 || options.threads > 1024)
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("sweep '{}': {} threads, expected 1 to 1024", pass.name, options.threads));
  // With a window of its own, because an error that ends a window leaves its levels unfinished.
  const std::uint64_t needed_bytes = sweep_window_bytes(store, pass, options.threads);
  if (needed_bytes > store.pager().budget_bytes())
    throw Error(
        ErrorCode::kBudget,
        fmt::format("sweep '{}': the window needs {} bytes of frames and the budget has {}; "
                    "the layout '{}' has stencils that span {} edges, and a block holds "
                    "{} bytes: raise the budget, take smaller blocks or another layout",
                    pass.name, needed_bytes, store.pager().budget_bytes(), store.options().layout,
                    measure_spans(store.base()).loop.span, store.options().block_bytes));
  SweepWindow window(store, pass);
  const auto edge_count = static_cast<EdgeId>(store.base().edge_count());
  const EdgeId chunk = window.chunk_edges(options.threads);
  SessionOptions session;
  session.window_bytes = needed_bytes;
  window.open(session);
  UnfinishedLevels written;
  for (const LevelAccess& access : pass.accesses)
    for (int level = access.first_level; level <= access.last_level; ++level)
      written.add(store.level_file(access.attribute, level), access.access);

  // At most the number of threads that the machine can run at once: TBB would print a warning and
  // ignore the others.
  const int concurrency = std::min(options.threads, tbb::this_task_arena::max_concurrency());
  std::optional<tbb::task_arena> arena;
  if (concurrency > 1) arena.emplace(concurrency);
  const auto chunk_end = [&](EdgeId first) { return first + std::min(chunk, edge_count - first); };
  window.plan(0, chunk_end(0));
  window.look_ahead(0, chunk);
  for (EdgeId first = 0; first < edge_count;) {
    const EdgeId after = chunk_end(first);
    window.advance();
    if (after < edge_count) {
      window.plan(after, chunk_end(after));
      window.look_ahead(after, chunk);
    }
    const SweepView& view = window.view();
    if (arena)
      arena->execute([&] {
        tbb::parallel_for(tbb::blocked_range<EdgeId>(first, after),
                          [&](const tbb::blocked_range<EdgeId>& range) {
                            const int worker = tbb::this_task_arena::current_thread_index();
                            for (EdgeId edge = range.begin(); edge < range.end(); ++edge)
                              pass.kernel(view, edge, worker);
                          });
      });
    else
      for (EdgeId edge = first; edge < after; ++edge) pass.kernel(view, edge, 0);
    first = after;
    if (options.proceed && !options.proceed(first, edge_count))
      throw Error(ErrorCode::kCancelled, fmt::format("sweep '{}': cancelled", pass.name));
  }
  written.finish();
}

PLAIT_END_NAMESPACE
