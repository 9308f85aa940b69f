#include "execution/slot_delivery.h"

#include <utility>

#include "execution/fused_levels.h"
#include "execution/half_merge.h"

namespace plait {

SlotDelivery::SlotDelivery(Store& store, const FusedPass& pass)
    : level_count_(static_cast<std::size_t>(fused_levels(store, pass))),
      mesh_(store.base().topology()),
      layout_(store, pass.outputs, fused_levels(store, pass), pass.lattice),
      pool_(layout_.bytes()),
      blocks_(store, pass.outputs, fused_levels(store, pass)),
      streaming_(blocks_.stays_in_memory()),
      waiting_(mesh_.edges.size(), nullptr) {}

SlotDelivery::Scratch::Scratch(const SlotDelivery& delivery) {
  // One line more, for pieces that would all begin in the same sets of the cache.
  const std::size_t lines = delivery.layout_.most_piece_bytes() / kLineBytes + 1;
  memory_.resize(lines * (3 * kPatchLanes + 1));
  std::byte* next = reinterpret_cast<std::byte*>(memory_.data());
  const auto take = [&] { return std::exchange(next, next + lines * kLineBytes); };
  for (LanePieces& lanes : pieces_)
    for (std::byte*& piece : lanes) piece = take();
  spare_ = take();
}

void SlotDelivery::deliver(const PatchRefiner& refiner, std::span<const FaceId> faces,
                           Scratch& scratch) {
  Sides sides = find_sides(faces);
  const Completes at_hand = place(sides, faces.size(), scratch);
  fill(refiner, sides, faces.size(), at_hand.all(), scratch);
  const Completes late = publish(sides, faces.size());
  fill_late(late.all(), scratch);
  if (streaming_) finish_streaming();
  const std::scoped_lock lock(mutex_);
  close(at_hand.all());
  close(late.all());
}

auto SlotDelivery::find_sides(std::span<const FaceId> faces) const -> Sides {
  Sides sides{};
  for (std::size_t lane = 0; lane < faces.size(); ++lane) {
    const int turn = first_corner(mesh_, faces[lane]);
    for (int side = 0; side < 3; ++side) {
      const FaceSide of_face(faces[lane], (side + turn) % 3);
      const EdgeId edge =
          mesh_.face_edges[of_face.face()][static_cast<std::size_t>(of_face.side())];
      sides[static_cast<std::size_t>(side)][lane] = {
          edge, mesh_.edges[edge].own == of_face, mesh_.edges[edge].is_border(), {}};
    }
  }
  return sides;
}

/// Says where every half goes, and which slots are complete with them. A border edge's half is
/// taken whole: its slot has other rows.
auto SlotDelivery::place(Sides& sides, std::size_t count, const Scratch& scratch) -> Completes {
  Completes complete;
  std::array<Side*, 3 * kPatchLanes> alone;
  std::size_t alone_count = 0;
  const auto complete_with = [&](const Side& side, const Place& mate) {
    complete.add(side.own ? Complete{side.edge, side.place, mate}
                          : Complete{side.edge, mate, side.place});
    open(side.edge);
  };
  const std::scoped_lock lock(mutex_);
  for (std::size_t number = 0; number < 3; ++number)
    for (std::size_t lane = 0; lane < count; ++lane) {
      Side& side = sides[number][lane];
      side.place = {scratch.pieces_[number][lane], false};
      if (std::byte* const waiting = std::exchange(waiting_[side.edge], nullptr)) {
        complete_with(side, {waiting, true});
        continue;
      }
      std::size_t mate = 0;
      while (mate < alone_count && alone[mate]->edge != side.edge) ++mate;
      if (mate == alone_count) {
        alone[alone_count++] = &side;
      } else {
        complete_with(side, alone[mate]->place);
        alone[mate] = alone[--alone_count];
      }
    }
  for (Side* const side : std::span(alone).first(alone_count)) side->place = {pool_.take(), true};
  return complete;
}

void SlotDelivery::fill(const PatchRefiner& refiner, const Sides& sides, std::size_t count,
                        std::span<const Complete> edges, Scratch& scratch) const {
  for (std::size_t output = 0; output < layout_.outputs().size(); ++output) {
    const void* const points = refiner.points(output);
    find_slots(output, edges, scratch);
    for (const HalfPiece& piece : layout_.pieces(output)) {
      scatter(output, piece, points, sides, count, scratch);
      merge(output, piece, edges, scratch.slots_);
    }
  }
}

void SlotDelivery::scatter(std::size_t output, const HalfPiece& piece, const void* points,
                           const Sides& sides, std::size_t count, const Scratch& scratch) const {
  const HalfOutput& shape = layout_.outputs()[output];
  const std::size_t offset = shape.offset + piece.at;
  for (std::size_t number = 0; number < 3; ++number) {
    LanePieces own, other;
    own.fill(scratch.spare_);
    other.fill(scratch.spare_);
    bool any_own = false, any_other = false;
    for (std::size_t lane = 0; lane < count; ++lane) {
      const Side& side = sides[number][lane];
      (side.own ? own : other)[lane] = side.place.piece(offset);
      (side.own ? any_own : any_other) = true;
    }
    if (any_own) scatter_piece(shape, points, piece.moves[number].own, own);
    if (any_other) scatter_piece(shape, points, piece.moves[number].other, other);
  }
}

void SlotDelivery::merge(std::size_t output, const HalfPiece& piece,
                         std::span<const Complete> edges, std::span<std::byte* const> slots) const {
  const std::size_t offset = layout_.outputs()[output].offset + piece.at;
  for (const auto& [edge, own, other] : edges) {
    for (const HalfPiece::Part& part : piece.parts)
      merge_part(piece, part, own.piece(offset), other.piece(offset), streaming_,
                 slots[static_cast<std::size_t>(part.level - 1)]);
    slots = slots.subspan(level_count_);
  }
}

void SlotDelivery::find_slots(std::size_t output, std::span<const Complete> edges,
                              Scratch& scratch) const {
  scratch.slots_.clear();
  for (const Complete& complete : edges)
    blocks_.add_slots(output, complete.edge, mesh_.border_rank(complete.edge), scratch.slots_);
}

/// Whole halves wait from now on. Complete are those of border edges, and those whose other half
/// another thread has published in the meantime.
auto SlotDelivery::publish(const Sides& sides, std::size_t count) -> Completes {
  Completes complete;
  const std::scoped_lock lock(mutex_);
  for (const auto& lanes : sides)
    for (const Side& side : std::span(lanes).first(count)) {
      if (!side.place.whole) continue;
      std::byte*& waiting = waiting_[side.edge];
      if (!waiting && !side.border) {
        waiting = side.place.memory;
        continue;
      }
      const Place mate{std::exchange(waiting, nullptr), true};
      complete.add(side.own ? Complete{side.edge, side.place, mate}
                            : Complete{side.edge, mate, side.place});
      open(side.edge);
    }
  return complete;
}

void SlotDelivery::fill_late(std::span<const Complete> edges, Scratch& scratch) const {
  for (std::size_t output = 0; output < layout_.outputs().size(); ++output) {
    find_slots(output, edges, scratch);
    const HalfOutput& shape = layout_.outputs()[output];
    std::span<std::byte* const> slots(scratch.slots_);
    for (std::size_t i = 0; i < edges.size(); ++i) {
      const std::span<const Complete> edge = edges.subspan(i, 1);
      for (const HalfPiece& piece : layout_.pieces(output)) {
        if (edge.front().other.memory) {
          merge(output, piece, edge, slots);
          continue;
        }
        for (const HalfPiece::Part& part : piece.parts)
          if (part.in_slot == 0)
            pack_border_slot(shape.record_bytes, part.level,
                             edge.front().own.memory + shape.offset + piece.at + part.at,
                             slots[static_cast<std::size_t>(part.level - 1)]);
      }
      slots = slots.subspan(level_count_);
    }
  }
}

void SlotDelivery::close(std::span<const Complete> edges) {
  for (const auto& [edge, own, other] : edges) {
    blocks_.close(edge);
    for (const Place& place : {own, other})
      if (place.whole && place.memory) pool_.give_back(place.memory);
  }
}

void SlotDelivery::open(EdgeId edge) {
  if (failure_) std::rethrow_exception(failure_);
  try {
    blocks_.open(edge);
  } catch (...) {
    // The next pin would say no more than that a write has failed.
    failure_ = std::current_exception();
    throw;
  }
}

}  // namespace plait
