#include "write_patches.h"

#include <algorithm>
#include <atomic>
#include <cstdint>

#include "base/run_workers.h"
#include "base/threads.h"
#include "plait/detail/level_file.h"
#include "plait/extend/pager.h"
#include "plait/extend/store_access.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

namespace {

/// The most that the blocks of one patch of an attribute take.
std::uint64_t block_bytes_of_patch(const Store& store) {
  if (StoreAccess::backend_traits(store).in_memory) return 0;
  std::uint64_t most = 0;
  for (AttributeId id = 0; id < store.attributes().size(); ++id) {
    std::uint64_t bytes = 0;
    for (int level = store.base_level() + 1; level <= store.attributes()[id].finest_level; ++level)
      bytes += 3 * StoreAccess::level_file(store, id, level).geometry.max_block_bytes();
    most = std::max(most, bytes);
  }
  return most;
}

}  // namespace

void write_patches(Store& store, const PatchFilling& filling) {
  const std::uint64_t faces = store.base().face_count(), step = filling.faces_at_once;
  const std::uint64_t budget = StoreAccess::pager(store).budget_bytes(),
                      blocks = block_bytes_of_patch(store);
  int threads = filling.threads;
  const auto lent_bytes = [&] {
    return static_cast<std::uint64_t>(threads - 1) * filling.scratch_bytes;
  };
  while (threads > 1 && (lent_bytes() > budget || blocks > budget - lent_bytes()))
    threads = fewer_threads(threads);
  if (filling.begins) filling.begins(threads);
  const LentMemory lent(StoreAccess::pager(store), lent_bytes());
  PatchWriter writer(store, filling.writer);
  std::atomic<std::uint64_t> next = 0;
  run_workers(store.options().parallel_for, threads, filling.job,
              {[&](int, const auto& report) {
                 for (std::uint64_t first = next.fetch_add(step); first < faces;
                      first = next.fetch_add(step)) {
                   filling.fill(writer, static_cast<FaceId>(first),
                                static_cast<FaceId>(std::min(first + step, faces)));
                   report();
                 }
               },
               [&] { filling.report(static_cast<FaceId>(std::min(next.load(), faces))); },
               [&] { next = faces; }});
  // Another thread may have taken all faces before this one came to report any.
  filling.report(static_cast<FaceId>(faces));
  writer.finish();
}

PLAIT_END_NAMESPACE
