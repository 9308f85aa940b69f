// plait/level_cursor.h: the slots of one level in the order of edges, with one block pinned at a
// time and the next ones on their way.
#pragma once

#include <utility>

#include "plait/pinned_level.h"

namespace plait {

/// One thread. Must not outlive the level.
class LevelCursor {
 public:
  /// For reading, by a session of its own.
  LevelCursor(Session session, const LevelFile& file)
      : session_(std::move(session)), level_(file) {}
  LevelCursor(Session session, LevelFile& file, Access access)
      : session_(std::move(session)), level_(file, access) {}

  const LevelGeometry& geometry() const { return level_.geometry(); }
  /// Valid until the next call. Edges ascend from call to call. Errors: those of Session::pin.
  LocatedSlot slot(EdgeId edge) {
    if (!level_.is_pinned(edge)) move_to(edge);
    return level_.slot(edge);
  }

 private:
  void move_to(EdgeId edge);

  Session session_;
  PinnedLevel level_;
};

}  // namespace plait
