#include "plait/verify.h"

#include <vector>

#include "maintenance/read_block.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

VerifyReport verify(Store& store, const std::function<bool(std::uint64_t, std::uint64_t)>& proceed,
                    const std::function<void(const BlockAddress&)>& damaged) {
  constexpr std::size_t kMaxReported = 1000;
  std::uint64_t total_bytes = 0;
  for (AttributeId id = 0; id < store.attributes().size(); ++id)
    for (int level = store.base_level() + 1; level <= store.attributes()[id].finest_level; ++level)
      total_bytes += store.level_file(id, level).geometry.total_bytes();

  // Blocks are read past the pager: what it holds must be where they are kept.
  store.pager().flush();
  VerifyReport report;
  std::vector<std::byte> buffer;
  for (AttributeId id = 0; id < store.attributes().size(); ++id) {
    const AttributeInfo& info = store.attributes()[id];
    for (int level = store.base_level() + 1; level <= info.finest_level; ++level) {
      LevelFile& file = store.level_file(id, level);
      buffer.resize(file.geometry.max_block_bytes());
      for (std::uint64_t block = 0; block < file.geometry.block_count(); ++block) {
        const std::uint64_t bytes = file.geometry.block_bytes(block);
        ++report.blocks;
        report.bytes += bytes;
        if (file.table[block].encoding == BlockEncoding::kNeverWritten) ++report.never_written;
        try {
          read_block(store, id, level, block, std::span(buffer).first(bytes));
        } catch (const Error& error) {
          // A bad place on the disk is an error of reading; the blocks beside it may be whole.
          if (error.code() != ErrorCode::kCorruption && error.code() != ErrorCode::kIo) throw;
          // A derived block has no bytes that can be damaged, only those that it is computed from.
          if (file.is_derived) continue;
          ++report.damaged_count;
          if (damaged) damaged({id, level, block});
          if (report.damaged.size() < kMaxReported)
            report.damaged.push_back({info.schema.name, level, block, file.table[block].offset,
                                      file.geometry.first_edge(block),
                                      file.geometry.edge_after(block), error.what()});
        }
        if (proceed && !proceed(report.bytes, total_bytes))
          throw Error(ErrorCode::kCancelled, "verify: cancelled");
      }
    }
  }
  return report;
}

PLAIT_END_NAMESPACE
