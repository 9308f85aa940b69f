// Turns refined groups of patches into slots, and writes these into blocks.
// A slot needs both of its halves. If the other face of the edge is in the same group, or was
// refined before, the slot is complete. Then this class fills the slot piece by piece, and needs no
// buffer for the whole new half. Otherwise it keeps the whole half until the other half comes.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <span>
#include <vector>

#include "execution/fused/half_layout.h"
#include "execution/fused/half_merge.h"
#include "execution/fused/half_pool.h"
#include "execution/fused/half_scatter.h"
#include "execution/fused/open_blocks.h"
#include "plait/extend/fused.h"
#include "plait/extend/store_access.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The mesh of a pass, or a piece of it.
struct FusedMesh {
  Topology mesh;
  EdgeRange edges;         ///< whose slots are made, in numbers of `mesh`
  EdgeId first_edge_here;  ///< edges.first, as the store numbers it

  std::uint64_t edge_count() const { return edges.after - edges.first; }
};

/// Safe from several threads, if each has its own Scratch. The two faces of an edge meet in one
/// atomic word (waiting_): the first one leaves its half there, the second one takes it and fills
/// the slot. No lock is held while blocks are pinned.
class SlotDelivery {
 public:
  /// `blocks` outlives the object. Errors: kOutOfMemory.
  SlotDelivery(Store& store, const FusedPass& pass, const FusedMesh& mesh, OpenBlocks& blocks);

  /// Memory for the pieces of a group's halves.
  class Scratch {
   public:
    explicit Scratch(const SlotDelivery& delivery);
    Scratch(const Scratch&) = delete;
    Scratch& operator=(const Scratch&) = delete;

   private:
    friend class SlotDelivery;
    struct alignas(kLineBytes) Line {
      std::array<std::byte, kLineBytes> bytes;
    };
    /// The buffers of own halves, or of other halves. Lanes of the other kind write to `spare_`.
    struct Lanes {
      bool any = false;
      std::array<HalfBuffer, kPatchLanes> buffers;
    };
    std::vector<Line> memory_;
    std::array<LanePieces, 3> pieces_;  ///< [side]
    std::byte* spare_;                  ///< nobody reads it
    std::array<Lanes, 3> own_, other_;  ///< [side] of the group
    std::vector<std::byte*> slots_;     ///< [complete edge][level - 1] of one output
    std::vector<EdgeHalves> halves_;    ///< [complete edge] of one output
  };

  /// Writes the slots of the refiner's last group; `faces` are the faces of the group. Errors:
  /// those of Session::pin. After the first error, all threads get this error, and not later errors
  /// that follow from it.
  void deliver(const PatchRefiner& refiner, std::span<const FaceId> faces, Scratch& scratch);

 private:
  struct Side {
    EdgeId edge;  ///< as the store numbers it; undefined unless is_mine
    bool own, border;
    bool is_mine = true;  ///< the store has the edge's slots
    /// The piece of the other side of the same edge if that is in the same group, else nullptr.
    std::byte* mate = nullptr;
    HalfBuffer buffer;
  };
  using Sides = std::array<std::array<Side, kPatchLanes>, 3>;
  struct Complete {
    EdgeId edge;
    HalfBuffer own, other;
  };
  /// Edges whose slots are complete: at most one for each side of a group.
  struct Completes {
    std::array<Complete, 3 * kPatchLanes> edges;
    std::size_t count = 0;

    void add(const Complete& edge) { edges[count++] = edge; }
    std::span<const Complete> all() const { return std::span(edges).first(count); }
  };

  /// The sides whose edge's other half is neither in the group nor made before.
  struct FirstSides {
    std::array<Side*, 3 * kPatchLanes> sides;
    std::size_t count = 0;

    std::span<Side* const> all() const { return std::span(sides).first(count); }
  };

  using EdgesOfGroup = std::array<EdgeId, 3 * kPatchLanes>;
  using HalvesOfGroup = std::array<std::byte*, 3 * kPatchLanes>;

  /// Whether the pass makes the slots of the edge with this number in mesh_.
  bool is_mine(EdgeId number) const {
    return number >= mesh_.edges.first && number < mesh_.edges.after;
  }
  void find_sides(std::span<const FaceId> faces, const Scratch& scratch, Sides& sides) const;
  Completes assign_buffers(Sides& sides, std::size_t count, const Scratch& scratch,
                           FirstSides& first);
  void fill(const PatchRefiner& refiner, const Sides& sides, std::size_t count,
            std::span<const Complete> edges, Scratch& scratch) const;
  void find_lanes(const Sides& sides, std::size_t count, Scratch& scratch) const;
  void scatter(std::size_t output, const HalfPiece& piece, const void* points,
               const Scratch& scratch) const;
  Completes publish(std::span<Side* const> first);
  void fill_late(std::span<const Complete> edges, Scratch& scratch) const;
  std::span<const EdgeHalves> find_slots(std::size_t output, std::span<const Complete> edges,
                                         Scratch& scratch) const;
  /// From open() to close(), the blocks of an edge's slots are pinned.
  void open(std::span<const Complete> edges);
  void close(std::span<const Complete> edges);
  static std::span<const EdgeId> edges_of(std::span<const Complete> edges, EdgesOfGroup& ids);

  std::size_t level_count_;
  const FusedMesh mesh_;
  const HalfLayout layout_;
  HalfPool pool_;
  OpenBlocks& blocks_;
  const bool streaming_;
  std::atomic<std::byte*>& waiting_at(EdgeId edge) {
    return waiting_[edge - mesh_.first_edge_here];
  }

  /// [edge of mesh_.edges] the half that waits for the other half, or nullptr
  std::vector<std::atomic<std::byte*>> waiting_;
  std::atomic<bool> failed_ = false;
  std::mutex mutex_;  ///< for the following
  std::exception_ptr failure_;
};

PLAIT_END_NAMESPACE
