// Fills attributes of a new store patch by patch, from several threads.
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>

#include "plait/patch_writer.h"
#include "plait/store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct PatchFilling {
  std::string_view job;  ///< for messages
  PatchWriterOptions writer = {};
  int threads = 1;
  FaceId faces_at_once = 1;
  /// The memory that a call of `fill` takes. The budget of the store lends that of all threads but
  /// the first one; fewer threads are taken if it does not fit beside the blocks of a patch.
  std::uint64_t scratch_bytes = 0;
  /// Called once with the threads that are taken, before any work. May be empty.
  std::function<void(int threads)> begins = {};
  /// Writes the patches of faces `first` to before `after`. Several threads call it at once.
  std::function<void(PatchWriter& writer, FaceId first, FaceId after)> fill;
  /// Called between two calls of `fill`, one at a time (SharedWork::report), and at the end.
  std::function<void(FaceId done)> report;
};

/// Calls `fill` for all base faces, on the threads of the store's parallel_for if it has one, and
/// finishes the levels. Errors: the first one of `fill` or `report`; those of PatchWriter and
/// run_workers().
void write_patches(Store& store, const PatchFilling& filling);

PLAIT_END_NAMESPACE
