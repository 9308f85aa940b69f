#include <algorithm>
#include <cstring>

#include "plait/convert.h"
#include "plait/error.h"

namespace plait {
namespace {

/// Walks the blocks of a level in order, holding one at a time: a sweep of its own.
class BlockCursor {
 public:
  BlockCursor(Store& store, LevelFile& file, Access access)
      : session_(store.open_session()), file_(file), access_(access) {}
  std::span<std::byte> slot(EdgeId edge) {
    const std::uint64_t block = file_.geometry.block_of(edge);
    if (!pinned_ || block != block_) {
      pinned_ = {};
      pinned_ = session_.pin(file_, block, access_);
      block_ = block;
      if (access_ == Access::kRead) read_ahead();
    }
    return pinned_.bytes().subspan(
        file_.geometry.slot_offset(edge) - file_.geometry.block_offset(block),
        file_.geometry.slot_bytes(edge));
  }

 private:
  void read_ahead() {
    const std::uint64_t end = std::min(file_.geometry.block_count(), block_ + 1 + Pager::kInFlight);
    for (ahead_ = std::max(ahead_, block_ + 1); ahead_ < end; ++ahead_)
      if (!session_.prefetch(file_, ahead_)) return;
  }

  Session session_;
  LevelFile& file_;
  Access access_;
  std::uint64_t block_ = 0, ahead_ = 0;
  PinnedBlock pinned_;
};

}  // namespace

void copy_levels(Store& from, Store& to,
                 const std::function<bool(std::uint64_t, std::uint64_t)>& proceed) {
  to.set_provenance(from.provenance());
  std::uint64_t total_bytes = 0, done_bytes = 0;
  for (AttributeId id = 0; id < from.attributes().size(); ++id)
    for (int level = from.base_level() + 1; level <= from.attributes()[id].finest_level; ++level)
      total_bytes += from.level_file(id, level).geometry.total_bytes();

  const auto edges = static_cast<EdgeId>(from.base().edge_count());
  for (AttributeId id = 0; id < from.attributes().size(); ++id) {
    const AttributeInfo& info = from.attributes()[id];
    const AttributeId copy = to.add_attribute(info.schema);
    std::ranges::copy(from.base_bytes(id), to.base_bytes(copy).begin());
    for (int level = from.base_level() + 1; level <= info.finest_level; ++level) {
      to.add_level(copy);
      const LevelGeometry& geometry = from.level_file(id, level).geometry;
      UnfinishedLevels written;
      written.add(to.level_file(copy, level), Access::kWrite);
      BlockCursor source(from, from.level_file(id, level), Access::kRead);
      BlockCursor target(to, to.level_file(copy, level), Access::kWrite);
      for (EdgeId edge = 0; edge < edges; ++edge) {
        const std::span<std::byte> slot = source.slot(edge);
        std::memcpy(target.slot(edge).data(), slot.data(), slot.size());
        const std::uint64_t block = geometry.block_of(edge);
        if (edge + 1 != geometry.edge_after(block)) continue;
        done_bytes += geometry.block_bytes(block);
        if (proceed && !proceed(done_bytes, total_bytes))
          throw Error(ErrorCode::kCancelled, "copy levels: cancelled");
      }
      written.finish();
    }
  }
}

}  // namespace plait
