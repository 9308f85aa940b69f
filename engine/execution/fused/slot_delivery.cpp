#include "execution/fused/slot_delivery.h"

#include <algorithm>
#include <functional>
#include <utility>

#include "execution/fused/fused_faces.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

SlotDelivery::SlotDelivery(Store& store, const FusedPass& pass, const FusedMesh& mesh,
                           OpenBlocks& blocks)
    : level_count_(static_cast<std::size_t>(level_count(store, pass))),
      mesh_(mesh),
      layout_(store, pass.outputs, level_count(store, pass), pass.lattice),
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
  find_sides(faces, scratch, sides);
  FirstSides first;
  const Completes at_hand = assign_buffers(sides, faces.size(), scratch, first);
  fill(refiner, sides, faces.size(), at_hand.all(), scratch);
  const Completes late = publish(first.all());
  fill_late(late.all(), scratch);
  if (streaming_) finish_streaming();
  close(at_hand.all());
  close(late.all());
}

void SlotDelivery::find_sides(std::span<const FaceId> faces, const Scratch& scratch,
                              Sides& sides) const {
  const Topology& mesh = mesh_.mesh;
  std::array<int, kPatchLanes> turns;
  for (std::size_t lane = 0; lane < faces.size(); ++lane) {
    turns[lane] = first_corner(mesh, faces[lane]);
    for (const EdgeId number : mesh.face_edges[faces[lane]]) {
      __builtin_prefetch(&mesh.edges[number]);
      if (is_mine(number)) __builtin_prefetch(&waiting_[number - mesh_.edges.first]);
    }
  }
  const bool one_by_one = faces.front() - faces.back() == faces.size() - 1;
  // At least the number of faces if the face is not in the group.
  const auto lane_of = [&](FaceId face) -> std::size_t {
    if (one_by_one) return faces.front() - face;
    const auto found = std::ranges::lower_bound(faces, face, std::ranges::greater());
    return found == faces.end() || *found != face ? faces.size()
                                                  : static_cast<std::size_t>(found - faces.begin());
  };
  // The place of a side in its patch, which is turned.
  const auto row_of = [](int side, int turn) {
    const int row = side - turn;
    return static_cast<std::size_t>(row < 0 ? row + 3 : row);
  };
  for (std::size_t lane = 0; lane < faces.size(); ++lane)
    for (int of_face = 0; of_face < 3; ++of_face) {
      const FaceSide here(faces[lane], of_face);
      const EdgeId number = mesh.face_edges[faces[lane]][static_cast<std::size_t>(of_face)];
      const Edge& edge = mesh.edges[number];
      FaceSide beyond;
      beyond.code = edge.own.code ^ edge.other.code ^ here.code;
      const std::size_t beyond_lane = lane_of(beyond.face());
      const bool in_group = beyond_lane < faces.size();
      const std::size_t mate = in_group ? beyond_lane : 0;
      Side& side = sides[row_of(of_face, turns[lane])][lane];
      side.edge = mesh_.first_edge_here + (number - mesh_.edges.first);
      side.own = edge.own == here;
      side.border = edge.is_border();
      side.is_mine = is_mine(number);
      side.mate = in_group ? scratch.pieces_[row_of(beyond.side(), turns[mate])][mate] : nullptr;
    }
}

/// Assigns a buffer to every half, and returns the edges whose slots are complete with these
/// halves. A border edge gets a buffer for the whole half, because its slot has rows of another
/// length. What a side is has no branch, because processors would predict it badly.
auto SlotDelivery::assign_buffers(Sides& sides, std::size_t count, const Scratch& scratch,
                                  FirstSides& first) -> Completes {
  Completes complete;
  for (std::size_t number = 0; number < 3; ++number)
    for (std::size_t lane = 0; lane < count; ++lane) {
      Side& side = sides[number][lane];
      if (!side.is_mine) continue;
      const HalfBuffer mine(scratch.pieces_[number][lane], HalfBuffer::kPiece);
      side.buffer = mine;
      // If the mate is in the group, no half waits.
      std::byte* const waiting = waiting_at(side.edge).load(std::memory_order_acquire);
      const bool waits = waiting != nullptr, has_mate = side.mate != nullptr;
      const HalfBuffer other = waits ? HalfBuffer(waiting, HalfBuffer::kWhole)
                                     : HalfBuffer(side.mate, HalfBuffer::kPiece);
      complete.edges[complete.count] = {side.edge, side.own ? mine : other,
                                        side.own ? other : mine};
      complete.count += static_cast<std::size_t>(waits | (has_mate & side.own));
      first.sides[first.count] = &side;
      first.count += static_cast<std::size_t>(!waits & !has_mate);
    }
  // An edge has two faces. So nobody else looks for these halves, or leaves others.
  for (const Complete& edge : complete.all())
    waiting_at(edge.edge).store(nullptr, std::memory_order_relaxed);
  HalvesOfGroup halves;
  const std::span<std::byte*> taken = std::span(halves).first(first.count);
  pool_.take(taken);
  for (std::size_t i = 0; i < first.count; ++i)
    first.sides[i]->buffer = {taken[i], HalfBuffer::kWhole};
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
  const HalfBuffer nowhere(scratch.spare_, HalfBuffer::kPiece);
  for (std::size_t number = 0; number < 3; ++number) {
    Scratch::Lanes &own = scratch.own_[number], &other = scratch.other_[number];
    own.any = other.any = false;
    own.buffers.fill(nowhere);
    other.buffers.fill(nowhere);
    for (std::size_t lane = 0; lane < count; ++lane) {
      const Side& side = sides[number][lane];
      const bool is_own = side.is_mine & side.own, is_other = side.is_mine & !side.own;
      own.any |= is_own;
      other.any |= is_other;
      own.buffers[lane] = is_own ? side.buffer : nowhere;
      other.buffers[lane] = is_other ? side.buffer : nowhere;
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
auto SlotDelivery::publish(std::span<Side* const> first) -> Completes {
  Completes complete;
  for (const Side* const side : first) {
    std::byte* half = nullptr;
    if (!side->border &&
        waiting_at(side->edge).compare_exchange_strong(half, side->buffer.memory()))
      continue;
    if (half) waiting_at(side->edge).store(nullptr, std::memory_order_relaxed);
    const HalfBuffer mate(half, HalfBuffer::kWhole);
    complete.add(side->own ? Complete{side->edge, side->buffer, mate}
                           : Complete{side->edge, mate, side->buffer});
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
        if (halves.other.memory()) {
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

void SlotDelivery::close(std::span<const Complete> edges) {
  if (edges.empty()) return;
  EdgesOfGroup ids;
  blocks_.close(edges_of(edges, ids));
  std::array<std::byte*, 6 * kPatchLanes> halves;  // two of each edge
  std::size_t count = 0;
  for (const auto& [edge, own, other] : edges)
    for (const HalfBuffer& buffer : {own, other}) {
      halves[count] = buffer.memory();
      count += static_cast<std::size_t>(buffer.whole() & (buffer.memory() != nullptr));
    }
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
