#include "execution/writer/written_attribute.h"

#include <algorithm>

#include "plait/extend/base_relative_level.h"
#include "plait/extend/store_access.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

WrittenAttribute::WrittenAttribute(Store& store, AttributeId id, int first, int last)
    : schema_(store.attributes()[id].schema),
      mesh_(store.base().topology()),
      first_(first),
      last_(last),
      coarsest_(std::max(first, 1)),
      base_(first == 0 ? store.base_bytes(id) : std::span<std::byte>()) {
  const std::size_t faces = mesh_.faces.size();
  for (int level = first; level <= last; ++level)
    faces_.push_back({std::vector<bool>(faces, false), faces});
  held_.reserve(static_cast<std::size_t>(std::max(last - coarsest_ + 1, 0)));
  for (int level = coarsest_; level <= last; ++level) {
    LevelFile& file = StoreAccess::level_file(
        store, id, level_number(BaseRelativeLevel(level), store.base_level()));
    const LevelGeometry& geometry = file.geometry;
    const std::size_t blocks = geometry.block_count();
    Blocks& of_level = blocks_.emplace_back(&file, std::vector<std::uint32_t>(blocks),
                                            std::vector<std::uint32_t>(blocks));
    for (EdgeId edge = 0; edge < mesh_.edges.size(); ++edge) {
      const SlotShape shape = geometry.slot(edge).shape;
      if (shape != SlotShape::kAbsent)
        of_level.to_fill[geometry.block_of(edge)] += shape == SlotShape::kHalf ? 1 : 2;
    }
    held_.emplace_back(file, Access::kUpdate);
  }
}

template <class Visit>
void WrittenAttribute::for_each_slot(FaceId face, int from, int to, Visit visit) const {
  for (int level = std::max(from, coarsest_); level <= to; ++level)
    for (const EdgeId edge : mesh_.face_edges[face]) visit(place_of(level), edge);
}

std::span<PinnedLevel> WrittenAttribute::held_of(int from, int to) {
  const int coarsest = std::max(from, coarsest_);
  if (to < coarsest) return {};
  return std::span(held_).subspan(place_of(coarsest), static_cast<std::size_t>(to - coarsest + 1));
}

std::uint64_t WrittenAttribute::need(FaceId face, int from, int to) {
  for_each_slot(face, from, to, [&](std::size_t at, EdgeId edge) { held_[at].need(edge); });
  std::uint64_t missing = 0;
  for (const PinnedLevel& level : held_of(from, to)) missing += level.missing_bytes();
  return missing;
}

void WrittenAttribute::use(Session& session, FaceId face, int from, int to) {
  PinnedLevel::pin_needed(session, held_of(from, to));
  for_each_slot(face, from, to, [&](std::size_t at, EdgeId edge) {
    ++blocks_[at].users[held_[at].geometry().block_of(edge)];
  });
}

void WrittenAttribute::end_use(FaceId face, int from, int to) noexcept {
  for_each_slot(face, from, to, [&](std::size_t at, EdgeId edge) {
    --blocks_[at].users[held_[at].geometry().block_of(edge)];
  });
  for_each_slot(face, from, to, [&](std::size_t at, EdgeId edge) {
    const std::uint64_t block = held_[at].geometry().block_of(edge);
    if (blocks_[at].to_fill[block] == 0 && blocks_[at].users[block] == 0 &&
        held_[at].is_pinned(edge))
      held_[at].release(edge);
  });
}

void WrittenAttribute::note_written(FaceId face, int from, int to) noexcept {
  for (int level = from; level <= to; ++level) {
    Faces& faces = faces_[static_cast<std::size_t>(level - first_)];
    if (faces.written[face]) continue;
    faces.written[face] = true;
    --faces.missing;
    for_each_slot(face, level, level, [&](std::size_t at, EdgeId edge) {
      --blocks_[at].to_fill[held_[at].geometry().block_of(edge)];
    });
  }
}

PinnedLevel* WrittenAttribute::oldest_idle() noexcept {
  PinnedLevel* oldest = nullptr;
  for (std::size_t at = 0; at < held_.size(); ++at) {
    PinnedLevel& level = held_[at];
    if (level.has_rest() && blocks_[at].users[level.oldest_block()] == 0 &&
        (!oldest || level.oldest_step() < oldest->oldest_step()))
      oldest = &level;
  }
  return oldest;
}

void WrittenAttribute::release_all() noexcept {
  for (PinnedLevel& level : held_) {
    level.begin_step();
    level.release_rest();
  }
}

FaceSlots WrittenAttribute::slots(FaceId face, int from, int to) const {
  FaceSlots slots;
  const std::size_t record_bytes = schema_.record_bytes();
  if (!base_.empty()) slots.set_corners(mesh_, face, 0, base_.data(), record_bytes);
  for (int level = std::max(from, coarsest_); level <= to; ++level)
    for (int side = 0; side < 3; ++side)
      slots.set(side, level,
                held_[place_of(level)].slot(mesh_.face_edges[face][static_cast<std::size_t>(side)]),
                mesh_.is_own(face, side), record_bytes);
  return slots;
}

FaceId WrittenAttribute::first_missing(int level) const {
  const std::vector<bool>& written = faces_at(level).written;
  return static_cast<FaceId>(std::ranges::find(written, false) - written.begin());
}

PLAIT_END_NAMESPACE
