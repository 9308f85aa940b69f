// paging/level_cursor.h: visits the slots of one level in the order of edges. It pins one block at
// a time and prefetches the next ones.
#pragma once

#include <memory>
#include <utility>

#include "plait/detail/namespace.h"
#include "plait/detail/pinned_level.h"

PLAIT_BEGIN_NAMESPACE

/// For one thread. Must not outlive the level.
class LevelCursor {
 public:
  /// Opens the level for reading. The cursor owns its session.
  LevelCursor(Session session, const LevelFile& file)
      : LevelCursor(std::make_shared<Session>(std::move(session)), file) {}
  LevelCursor(Session session, LevelFile& file, Access access)
      : LevelCursor(std::make_shared<Session>(std::move(session)), file, access) {}
  /// Cursors that move through several levels together share a session. Then its policy sees all
  /// their blocks: what nobody needs any more leaves before what the next blocks are decoded from.
  LevelCursor(std::shared_ptr<Session> session, const LevelFile& file)
      : session_(std::move(session)), level_(file) {}
  LevelCursor(std::shared_ptr<Session> session, LevelFile& file, Access access)
      : session_(std::move(session)), level_(file, access) {}

  const LevelGeometry& geometry() const { return level_.geometry(); }
  /// Valid until the next call. Edges ascend from call to call. Errors: those of Session::pin.
  LocatedSlot slot(EdgeId edge) {
    if (!level_.is_pinned(edge)) move_to(edge);
    return level_.slot(edge);
  }

 private:
  void move_to(EdgeId edge);

  std::shared_ptr<Session> session_;
  PinnedLevel level_;
};

PLAIT_END_NAMESPACE
