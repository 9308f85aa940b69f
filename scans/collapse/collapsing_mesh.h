// collapse/collapsing_mesh.h: a surface whose edges collapse. Faces and vertices keep their numbers
// while they live, so the numbers of a scan stay valid in the collapse history.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "collapse/patch.h"
#include "plait/detail/namespace.h"
#include "surface/creases.h"
#include "surface/surface.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Pinned by tests/scans/decimate_test.cpp: after every collapse the mesh is an oriented manifold.
class CollapsingMesh {
 public:
  /// `corners` [vertex] 1: stays in its place. Empty: none.
  explicit CollapsingMesh(const Surface& scan, const Creases& creases = {},
                          std::vector<std::uint8_t> corners = {});

  const std::vector<std::array<VertexId, 3>>& faces() const { return faces_; }
  bool lives(FaceId face) const { return faces_[face][0] != kNoId; }
  bool is_border(VertexId vertex) const { return (lines_[vertex] & kBorder) != 0; }
  bool is_on_crease(VertexId vertex) const { return (lines_[vertex] & kCrease) != 0; }
  bool is_corner(VertexId vertex) const { return corners_[vertex] != 0; }
  bool is_crease(FaceSide side) const { return !creases_.empty() && creases_[side.code] != 0; }
  /// REQUIRES: no other thread collapses.
  std::uint64_t live_faces() const { return live_faces_; }

  VertexId start(FaceSide edge) const { return at(edge.face(), edge.side() + 1); }
  VertexId end(FaceSide edge) const { return at(edge.face(), edge.side() + 2); }
  FaceSide across(FaceSide side) const { return across_[side.code]; }

  /// The faces around the edge that `side` is. Returns false if the collapse would change the
  /// topology (H. Edelsbrunner, "Geometry and topology for mesh generation", 2001: the link
  /// condition), that of borders, creases or corners, or if its fan would have more than kMaxFan
  /// faces. An end on a border or a crease is kept if the edge is not, and a corner is.
  bool gather(FaceSide side, Patch& patch) const;
  /// Replaces the patch by its fan. The vertex of the fan is patch.kept. Threads: any number, if
  /// no face of a patch is near one of another thread's: all faces at the patch's vertices `kept`
  /// and `gone` are this thread's.
  void collapse(const Patch& patch);

 private:
  VertexId at(FaceId face, int corner) const {
    return faces_[face][static_cast<std::size_t>(corner % 3)];
  }
  /// The next corner of the same vertex, counterclockwise; it does not exist at a border.
  FaceSide after(FaceSide corner) const {
    const FaceSide beyond = across_[3 * corner.face() + next_of(corner.side())];
    return beyond.exists() ? FaceSide(beyond.face(), (beyond.side() + 1) % 3) : FaceSide();
  }
  FaceSide before(FaceSide corner) const {
    const FaceSide beyond = across_[3 * corner.face() + next_of(corner.side() + 1)];
    return beyond.exists() ? FaceSide(beyond.face(), (beyond.side() + 2) % 3) : FaceSide();
  }
  static std::uint32_t next_of(int corner) { return static_cast<std::uint32_t>((corner + 1) % 3); }
  /// Adds the faces from `corner` on, counterclockwise, up to the face with corner `stop` or a
  /// border.
  bool add_fan(FaceSide corner, FaceSide stop, bool at_gone, Patch& patch) const;
  bool has_distinct_ring(const Patch& patch) const;
  /// Which end is kept; false if the edge has to stay.
  bool choose_kept(FaceSide& side) const;
  bool gather_ring(FaceSide side, Patch& patch) const;
  /// Sets the places of the creases at the ends; false if the collapse would join two of them.
  bool find_creases(Patch& patch) const;
  void remove_face(FaceSide corner_at_kept, bool left);

  std::vector<std::array<VertexId, 3>> faces_;
  std::vector<FaceSide> across_;
  static constexpr std::uint8_t kBorder = 1, kCrease = 2;
  std::vector<std::uint8_t> lines_;    // [vertex] what it is on
  std::vector<std::uint8_t> corners_;  // [vertex]
  std::vector<std::uint8_t> creases_;  // [3 face + side]; empty if there are none
  std::uint64_t live_faces_;
};

PLAIT_END_NAMESPACE
