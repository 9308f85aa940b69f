#include "execution/fused/slot_delivery.h"

#include <bit>
#include <utility>

#include "execution/fused/fused_faces.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

SlotDelivery::SlotDelivery(Store& store, const FusedPass& pass, const FusedMesh& mesh,
                           OpenBlocks& blocks)
    : level_count_(static_cast<std::size_t>(fused_levels(store, pass))),
      mesh_(mesh),
      layout_(store, pass.outputs, fused_levels(store, pass), pass.lattice),
      pool_(layout_.bytes()),
      blocks_(blocks),
      streaming_(blocks_.stays_in_memory()),
      waiting_(mesh.edge_count()) {}

SlotDelivery::Scratch::Scratch(const SlotDelivery& delivery) {
  // One extra cache line, because otherwise all pieces would begin in the same sets of the cache.
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
  Sides sides;
  find_sides(faces, sides);
  const Completes at_hand = assign_buffers(sides, faces.size(), scratch);
  fill(refiner, sides, faces.size(), at_hand.all(), scratch);
  const Completes late = publish(sides, faces.size());
  fill_late(late.all(), scratch);
  if (streaming_) finish_streaming();
  close(at_hand.all());
  close(late.all());
}

void SlotDelivery::find_sides(std::span<const FaceId> faces, Sides& sides) const {
  // A hash table of the sides visited so far, by edge. The edge number is the hash, because the
  // edges of neighbouring faces have close numbers.
  constexpr std::size_t kTableSize = std::bit_ceil(std::size_t{4} * 3 * kPatchLanes);
  std::array<std::uint8_t, kTableSize> seen{};  // 1 + number of the side in `sides`; 0: empty
  static_assert(3 * kPatchLanes < 255);
  const auto seen_at = [&](std::size_t at) -> Side& {
    const std::size_t number = seen[at] - std::size_t{1};
    return sides[number / kPatchLanes][number % kPatchLanes];
  };
  const Topology& mesh = mesh_.mesh;
  for (const FaceId face : faces)
    for (const EdgeId number : mesh.face_edges[face]) {
      __builtin_prefetch(&mesh.edges[number]);
      if (number >= mesh_.edges.first && number < mesh_.edges.after)
        __builtin_prefetch(&waiting_[number - mesh_.edges.first]);
    }
  for (std::size_t lane = 0; lane < faces.size(); ++lane) {
    const int turn = first_corner(mesh, faces[lane]);
    for (int at_corner = 0; at_corner < 3; ++at_corner) {
      const FaceSide of_face(faces[lane], (at_corner + turn) % 3);
      const EdgeId number =
          mesh.face_edges[of_face.face()][static_cast<std::size_t>(of_face.side())];
      const EdgeId edge = mesh_.first_edge_here + (number - mesh_.edges.first);
      const auto row = static_cast<std::size_t>(at_corner);
      Side& side = sides[row][lane];
      side = {edge,
              mesh.edges[number].own == of_face,
              mesh.edges[number].is_border(),
              number >= mesh_.edges.first && number < mesh_.edges.after,
              nullptr,
              {}};
      if (!side.is_here) continue;
      std::size_t at = edge % kTableSize;
      while (seen[at] != 0 && seen_at(at).edge != edge) at = (at + 1) % kTableSize;
      if (seen[at] != 0) {
        side.mate = &seen_at(at);
        side.mate->mate = &side;
      }
      seen[at] = static_cast<std::uint8_t>(row * kPatchLanes + lane + 1);
    }
  }
}

/// Assigns a buffer to every half, and returns the edges whose slots are complete with these
/// halves. A border edge gets a buffer for the whole half, because its slot has rows of another
/// length.
auto SlotDelivery::assign_buffers(Sides& sides, std::size_t count, const Scratch& scratch)
    -> Completes {
  Completes complete;
  const auto complete_with = [&](const Side& side, const HalfBuffer& mate) {
    complete.add(side.own ? Complete{side.edge, side.buffer, mate}
                          : Complete{side.edge, mate, side.buffer});
  };
  std::array<Side*, 3 * kPatchLanes> first;  // of their edges' two sides
  std::size_t first_count = 0;
  for (std::size_t number = 0; number < 3; ++number)
    for (std::size_t lane = 0; lane < count; ++lane) {
      Side& side = sides[number][lane];
      if (!side.is_here) continue;
      side.buffer = {scratch.pieces_[number][lane], HalfBuffer::kPiece};
      if (side.mate) {
        if (side.mate->buffer.memory) complete_with(side, side.mate->buffer);
      } else if (std::byte* const waiting = take_waiting(side.edge)) {
        complete_with(side, {waiting, HalfBuffer::kWhole});
      } else {
        first[first_count++] = &side;
      }
    }
  HalvesOfGroup halves;
  const std::span<std::byte*> taken = std::span(halves).first(first_count);
  pool_.take(taken);
  for (std::size_t i = 0; i < first_count; ++i) first[i]->buffer = {taken[i], HalfBuffer::kWhole};
  open(complete.all());
  return complete;
}

void SlotDelivery::fill(const PatchRefiner& refiner, const Sides& sides, std::size_t count,
                        std::span<const Complete> edges, Scratch& scratch) const {
  find_lanes(sides, count, scratch);
  for (std::size_t output = 0; output < layout_.outputs().size(); ++output) {
    const void* const points = refiner.points(output);
    const std::span<const EdgeHalves> halves = find_slots(output, edges, scratch);
    for (const HalfPiece& piece : layout_.pieces(output)) {
      scatter(output, piece, points, scratch);
      merge_piece(piece, layout_.outputs()[output].offset + piece.at, halves, streaming_);
    }
  }
}

void SlotDelivery::find_lanes(const Sides& sides, std::size_t count, Scratch& scratch) const {
  const HalfBuffer nowhere{scratch.spare_, HalfBuffer::kPiece};
  for (std::size_t number = 0; number < 3; ++number) {
    Scratch::Lanes &own = scratch.own_[number], &other = scratch.other_[number];
    own.any = other.any = false;
    own.buffers.fill(nowhere);
    other.buffers.fill(nowhere);
    for (std::size_t lane = 0; lane < count; ++lane) {
      const Side& side = sides[number][lane];
      if (!side.is_here) continue;
      Scratch::Lanes& lanes = side.own ? own : other;
      lanes.any = true;
      lanes.buffers[lane] = side.buffer;
    }
  }
}

void SlotDelivery::scatter(std::size_t output, const HalfPiece& piece, const void* points,
                           const Scratch& scratch) const {
  const HalfOutput& shape = layout_.outputs()[output];
  const auto scatter_lanes = [&](const Scratch::Lanes& lanes, std::span<const HalfMove> moves) {
    if (!lanes.any) return;
    LanePieces to;
    for (std::size_t lane = 0; lane < kPatchLanes; ++lane)
      to[lane] = lanes.buffers[lane].piece(shape.offset + piece.at);
    scatter_piece(shape, points, moves, to);
  };
  for (std::size_t number = 0; number < 3; ++number) {
    scatter_lanes(scratch.own_[number], piece.moves[number].own);
    scatter_lanes(scratch.other_[number], piece.moves[number].other);
  }
}

/// Finds the halves and the slots of these edges for one output.
auto SlotDelivery::find_slots(std::size_t output, std::span<const Complete> edges,
                              Scratch& scratch) const -> std::span<const EdgeHalves> {
  scratch.slots_.resize(edges.size() * level_count_);
  scratch.halves_.clear();
  std::byte** slots = scratch.slots_.data();
  for (const auto& [edge, own, other] : edges) {
    blocks_.find_slots(output, edge, slots);
    scratch.halves_.push_back({own, other, slots});
    slots += level_count_;
  }
  return scratch.halves_;
}

/// Publishes the whole halves of the group, so that other threads can complete their slots. Returns
/// the edges that are complete now: border edges, and edges whose other half another thread has
/// published in the meantime.
auto SlotDelivery::publish(const Sides& sides, std::size_t count) -> Completes {
  Completes complete;
  for (const auto& lanes : sides)
    for (const Side& side : std::span(lanes).first(count)) {
      if (!side.is_here || !side.buffer.whole()) continue;
      std::byte* nothing = nullptr;
      if (!side.border &&
          waiting_at(side.edge).compare_exchange_strong(nothing, side.buffer.memory))
        continue;
      const HalfBuffer mate{take_waiting(side.edge), HalfBuffer::kWhole};
      complete.add(side.own ? Complete{side.edge, side.buffer, mate}
                            : Complete{side.edge, mate, side.buffer});
    }
  open(complete.all());
  return complete;
}

void SlotDelivery::fill_late(std::span<const Complete> edges, Scratch& scratch) const {
  for (std::size_t output = 0; output < layout_.outputs().size(); ++output) {
    const HalfOutput& shape = layout_.outputs()[output];
    for (const EdgeHalves& halves : find_slots(output, edges, scratch))
      for (const HalfPiece& piece : layout_.pieces(output)) {
        const std::size_t offset = shape.offset + piece.at;
        if (halves.other.memory) {
          merge_piece(piece, offset, std::span(&halves, 1), streaming_);
          continue;
        }
        for (const HalfPiece::PartOfSlot& part : piece.parts)
          if (part.in_slot == 0)
            pack_border_slot(shape.record_bytes, part.level, halves.own.piece(offset) + part.at,
                             halves.slots[part.level - 1]);
      }
  }
}

std::byte* SlotDelivery::take_waiting(EdgeId edge) {
  std::atomic<std::byte*>& waiting = waiting_at(edge);
  std::byte* const half = waiting.load(std::memory_order_acquire);
  // An edge has two faces. So nobody else looks for the half, or leaves another one.
  if (half) waiting.store(nullptr, std::memory_order_relaxed);
  return half;
}

void SlotDelivery::close(std::span<const Complete> edges) {
  if (edges.empty()) return;
  EdgesOfGroup ids;
  blocks_.close(edges_of(edges, ids));
  std::array<std::byte*, 6 * kPatchLanes> halves;  // two of each edge
  std::size_t count = 0;
  for (const auto& [edge, own, other] : edges)
    for (const HalfBuffer& buffer : {own, other})
      if (buffer.whole() && buffer.memory) halves[count++] = buffer.memory;
  if (count > 0) pool_.give_back(std::span(halves).first(count));
}

void SlotDelivery::open(std::span<const Complete> edges) {
  if (failed_) {
    const std::scoped_lock lock(mutex_);
    std::rethrow_exception(failure_);
  }
  EdgesOfGroup ids;
  try {
    blocks_.open(edges_of(edges, ids));
  } catch (...) {
    // Later pins would only report that a write has failed, so this error is stored for them.
    const std::scoped_lock lock(mutex_);
    if (!failure_) failure_ = std::current_exception();
    failed_ = true;
    throw;
  }
}

auto SlotDelivery::edges_of(std::span<const Complete> edges, EdgesOfGroup& ids)
    -> std::span<const EdgeId> {
  for (std::size_t i = 0; i < edges.size(); ++i) ids[i] = edges[i].edge;
  return std::span(ids).first(edges.size());
}

PLAIT_END_NAMESPACE
