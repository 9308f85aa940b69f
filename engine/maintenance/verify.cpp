#include "plait/verify.h"

#include <utility>

#include "base/damage.h"
#include "maintenance/read_block.h"
#include "plait/error.h"
#include "plait/extend/store_access.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

VerifyReport verify(const Store& store, const ProgressCallback& progress,
                    const std::function<void(const BlockAddress&)>& damaged) try {
  constexpr std::size_t kMaxReported = 1000;
  std::uint64_t total_bytes = 0;
  for (AttributeId id = 0; id < store.attributes().size(); ++id)
    for (int level = store.base_level() + 1; level <= store.attributes()[id].finest_level; ++level)
      total_bytes += StoreAccess::level_file(store, id, level).geometry.total_bytes();

  const StorePass under_way(store);
  // Blocks are read from their files, so the pager must first write those that have changed.
  // That changes no record.
  StoreAccess::pager(const_cast<Store&>(store)).flush();
  VerifyReport report;
  RunBuffer buffer;
  for (AttributeId id = 0; id < store.attributes().size(); ++id) {
    const AttributeInfo& info = store.attributes()[id];
    for (int level = store.base_level() + 1; level <= info.finest_level; ++level) {
      const LevelFile& file = StoreAccess::level_file(store, id, level);
      for (std::uint64_t block = 0; block < file.geometry.block_count(); ++block) {
        const std::uint64_t bytes = file.geometry.block_bytes(block);
        ++report.blocks;
        report.bytes += bytes;
        const bool is_written = file.table[block].encoding != BlockEncoding::kNeverWritten;
        if (!is_written) ++report.never_written;
        try {
          if (is_written) buffer.read(store, id, level, block);
        } catch (const Error& error) {
          // A bad place on the disk is kIo. The blocks beside it may be whole.
          if (error.code() != ErrorCode::kCorruption && error.code() != ErrorCode::kIo) throw;
          ++report.damaged_count;
          if (damaged) damaged({id, level, block});
          if (report.damaged.size() < kMaxReported)
            report.damaged.push_back({info.schema.name, level, block, file.table[block].offset,
                                      file.geometry.first_edge(block),
                                      file.geometry.edge_after(block), without_cure(error)});
        }
        if (progress && !progress({"verify", report.bytes, total_bytes}))
          throw Error(ErrorCode::kCancelled, "verify: cancelled");
      }
    }
  }
  return report;
} catch (const std::bad_alloc&) {
  throw out_of_memory("verify " + store.path().native());
}

PLAIT_END_NAMESPACE
