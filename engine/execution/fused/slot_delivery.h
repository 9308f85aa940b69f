// From finished groups of patches to slots in blocks.
//
// A slot is complete when its second half is there. Where that is at hand, because the other face
// has delivered before or is in the same group, both halves go to the slot piece by piece and are
// never whole in memory; the others wait, whole.
#pragma once

#include <array>
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
#include "plait/fused.h"
#include "plait/topology.h"

namespace plait {

/// Safe from several threads, each with scratch of its own. Everything but what is in slots and
/// halves is under one lock, taken three times a group.
class SlotDelivery {
 public:
  SlotDelivery(Store& store, const FusedPass& pass);

  /// Where pieces of a group's halves are made.
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
    /// The halves of one kind, and where lanes of the other kind are thrown away.
    struct Lanes {
      bool any = false;
      std::array<HalfBuffer, kPatchLanes> buffers;
    };
    std::vector<Line> memory_;
    std::array<LanePieces, 3> pieces_;  ///< [side]
    std::byte* spare_;                  ///< for what is not wanted
    std::array<Lanes, 3> own_, other_;  ///< [side] of the group
    std::vector<std::byte*> slots_;     ///< [complete edge][level - 1] of one output
    std::vector<SlotHalves> halves_;    ///< [complete edge] of one output
  };

  /// Takes the refiner's last group, which was of these faces. Errors: those of Session::pin; after
  /// the first one every thread gets that, not what follows from it.
  void deliver(const PatchRefiner& refiner, std::span<const FaceId> faces, Scratch& scratch);

 private:
  struct Side {
    EdgeId edge;
    bool own, border;
    Side* mate;  ///< the other side of the same edge, where it is in the same group
    HalfBuffer buffer;
  };
  using Sides = std::array<std::array<Side, kPatchLanes>, 3>;
  struct Complete {
    EdgeId edge;
    HalfBuffer own, other;
  };
  /// At most one for each side of a group.
  struct Completes {
    std::array<Complete, 3 * kPatchLanes> edges;
    std::size_t count = 0;

    void add(const Complete& edge) { edges[count++] = edge; }
    std::span<const Complete> all() const { return std::span(edges).first(count); }
  };

  using EdgesOfGroup = std::array<EdgeId, 3 * kPatchLanes>;

  void find_sides(std::span<const FaceId> faces, Sides& sides) const;
  Completes assign_buffers(Sides& sides, std::size_t count, const Scratch& scratch);
  void fill(const PatchRefiner& refiner, const Sides& sides, std::size_t count,
            std::span<const Complete> edges, Scratch& scratch) const;
  void find_lanes(const Sides& sides, std::size_t count, Scratch& scratch) const;
  void scatter(std::size_t output, const HalfPiece& piece, const void* points,
               const Scratch& scratch) const;
  Completes publish(const Sides& sides, std::size_t count);
  void fill_late(std::span<const Complete> edges, Scratch& scratch) const;
  std::span<const SlotHalves> find_slots(std::size_t output, std::span<const Complete> edges,
                                         Scratch& scratch) const;
  /// REQUIRE the lock: from open() to close() an edge's slots are there to be filled.
  void open(std::span<const Complete> edges);
  void close(std::span<const Complete> edges);
  static std::span<const EdgeId> edges_of(std::span<const Complete> edges, EdgesOfGroup& ids);

  std::size_t level_count_;
  const Topology mesh_;
  const HalfLayout layout_;
  std::mutex mutex_;
  HalfPool pool_;
  OpenBlocks blocks_;
  const bool streaming_;
  std::vector<std::byte*> waiting_;  ///< [edge] the half that came first, until the other comes
  std::exception_ptr failure_;
};

}  // namespace plait
