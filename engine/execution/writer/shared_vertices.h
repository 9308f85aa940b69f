// The vertices that several patches of a PatchWriter have: each patch must have the same records of
// them.
#pragma once

#include <cstdint>
#include <vector>

#include "execution/writer/patch_records.h"
#include "execution/writer/written_attribute.h"
#include "plait/detail/face_slots.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Of one attribute. Not safe from several threads.
class SharedVertices {
 public:
  /// The arguments outlive this object.
  SharedVertices(const WrittenAttribute& attribute, const Topology& mesh, int base_level)
      : attribute_(&attribute),
        mesh_(&mesh),
        base_level_(base_level),
        has_vertex_(attribute.first() == 0 ? mesh.vertex_corners.size() : 0) {}

  /// Copies those vertices of the patch that refinements `from` to patch.level create, the corners
  /// with `from` 0. Errors: kInvalidArgument, before the first copy, if another patch has written
  /// another record.
  void write(const PatchRecords& patch, FaceId face, int from, const FaceSlots& slots);

 private:
  void compare(const PatchRecords& patch, FaceId face, int from, const FaceSlots& slots) const;
  /// `other` is kNoId for a corner.
  [[noreturn]] void refuse(const PatchRecords& patch, FaceId face, FaceId other, std::int64_t i,
                           std::int64_t j, const std::byte* found) const;

  const WrittenAttribute* attribute_;
  const Topology* mesh_;
  int base_level_;
  std::vector<bool> has_vertex_;  ///< [base vertex] whether a patch has written it
};

PLAIT_END_NAMESPACE
