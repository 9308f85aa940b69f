// Which triangle of a mesh has which role if the mesh is a coarser one, refined once: four
// triangles then come from one.
//
//            A                 The triangle in the middle has three new vertices. The other three
//           / \                have one kept vertex each. The role of one triangle determines the
//          c---b               roles of its neighbours, and so of its whole component. A vertex
//         / \ / \              with other than six neighbours (on a border: other than four) is
//        B---a---C             kept, because a new vertex has just this number.
//
// Source: G. Taubin, "Detecting and reconstructing subdivision connectivity", The Visual Computer
// 18, 2002, which finds the kept triangles as a covering of the mesh; here they follow from a
// vertex that must be kept. Pinned by tests/engine/mesh/recovery_test.cpp.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mesh/recovery/level_mesh.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Where a mesh is not a refined one.
struct RecoveryFailure {
  VertexId vertex = kNoId;  ///< its number in the file
  std::uint32_t faces = 0;  ///< at the vertex
  bool on_border = false;
  std::string reason;  ///< "it would be a new vertex, which has six faces"
};

class TriangleRoles {
 public:
  using Role = std::uint8_t;  ///< kMiddle, or kFirstCorner + the corner that is kept
  static constexpr Role kMiddle = 0, kFirstCorner = 1;

  /// `mesh` must outlive this object.
  explicit TriangleRoles(const LevelView& mesh);

  /// Finds the roles of all triangles. Returns false if there are none.
  bool find();
  /// REQUIRES: find() has failed.
  RecoveryFailure failure() const;
  /// Whether a component has only vertices that may be new, so that there was more than one answer.
  bool had_choice() const { return had_choice_; }

  bool is_middle(FaceId face) const { return role(face) == kMiddle; }
  /// The corner whose vertex is kept. REQUIRES: the face is no middle.
  FaceSide kept_corner(FaceId face) const { return {face, role(face) - kFirstCorner}; }

 private:
  static constexpr Role kUnknown = 7;
  /// A face has its role in the lowest bits, and above them one bit for each corner whose vertex
  /// may be new.
  static constexpr int kFirstMayBeNew = 4;
  static constexpr std::uint8_t kRoleBits = 7, kAllMayBeNew = 7 << kFirstMayBeNew;

  Role role(FaceId face) const { return faces_[face] & kRoleBits; }
  void put(FaceId face, Role role) {
    faces_[face] = static_cast<std::uint8_t>((faces_[face] & kAllMayBeNew) | role);
  }
  bool may_be_new(VertexId vertex) const;
  bool set(FaceId face, Role role);
  bool spread(FaceId first, Role role);
  bool spread_from(FaceId face);
  bool choose(VertexId smallest, FaceSide corner);
  std::optional<VertexId> smallest_kept(FaceId first, Role role);
  bool find_in_regular_components();
  bool fail(FaceSide at_vertex, const char* reason);

  const LevelView& mesh_;
  /// [vertex] faces at the vertex, 127 at most, and kBorder
  std::vector<std::uint8_t> around_;
  std::vector<std::uint8_t> faces_;
  /// Faces that have a role: the neighbours of `front_` are next, then those of `next_front_`.
  std::vector<FaceId> front_, next_front_;
  std::size_t next_size_ = 0;               ///< of next_front_, which has room for more
  std::vector<FaceId>* reached_ = nullptr;  ///< collects the faces that get a role
  bool had_choice_ = false;
  RecoveryFailure failure_;
};

PLAIT_END_NAMESPACE
