#include "paging/frame.h"

#include <cassert>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// A window keeps a context block for 16 times its own length, counted in edges. docs/benchmarks.md
/// has figures for other numbers.
constexpr std::uint64_t kContextLengths = 16;

}  // namespace

bool may_become(Frame::State from, Frame::State to) noexcept {
  using State = Frame::State;
  switch (from) {
    case State::kVacant:
      return to == State::kClaimed;
    case State::kClaimed:
      return to == State::kReading || to == State::kClean || to == State::kDirty ||
             to == State::kDetached || to == State::kVacant;
    case State::kReading:
      return to == State::kClean || to == State::kDetached || to == State::kClaimed;
    case State::kClean:
      return to == State::kDirty || to == State::kDetached || to == State::kVacant;
    case State::kDirty:
      return to == State::kClean || is_being_written(to) || to == State::kStuck ||
             to == State::kDetached || to == State::kVacant;
    case State::kWriting:
      return to == State::kClean || to == State::kDirty;
    case State::kWritingHeld:
      return to == State::kDirty;
    case State::kStuck:
      return to == State::kDetached || to == State::kVacant;
    case State::kDetached:
      return to == State::kVacant;
  }
  return false;
}

void keep_as_context(Frame& frame, EdgeId needed_until) noexcept {
  Frame::Content& content = frame.content;
  if (content.kept_edges > 0) return;
  content.needed_until = needed_until;
  const LevelGeometry& geometry = content.level->geometry;
  content.kept_edges = kContextLengths * std::uint64_t{geometry.edge_after(content.block) -
                                                       geometry.first_edge(content.block)};
}

void become(Frame& frame, Frame::State state) noexcept {
  assert(may_become(frame.content.state, state));
  if (state != Frame::State::kClean && state != Frame::State::kDirty) frame.pins.close();
  frame.content.state = state;
}

PLAIT_END_NAMESPACE
