#include "write_patches.h"

#include <algorithm>
#include <atomic>
#include <cstdint>

#include "base/run_workers.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

void write_patches(Store& store, const PatchFilling& filling) {
  const std::uint64_t faces = store.base().face_count(), step = filling.faces_at_once;
  PatchWriter writer(store, filling.writer);
  std::atomic<std::uint64_t> next = 0;
  run_workers(store.options().parallel_for, filling.threads, filling.job,
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
