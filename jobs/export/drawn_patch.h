// export/drawn_patch.h: the records of one face and, on sides with deeper neighbours, those of the
// vertices that only the faces across have (plait/detail/drawn_triangles.h).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "plait/detail/drawn_triangles.h"
#include "plait/detail/namespace.h"
#include "plait/extend/topology.h"
#include "plait/reader.h"
#include "plait/store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Reads one face after another, for faces that ascend. Pins the blocks of one face and of its
/// deeper neighbours. For one thread. The store must outlive it.
class DrawnPatch {
 public:
  /// Errors: kNotFound for an attribute that the store does not have.
  DrawnPatch(const Store& store, std::string attribute);

  /// `depths`: of the face, at most its own, and of its sides, at most those of the faces across.
  /// Errors: those of Reader::read_patch().
  void read(FaceId face, const DrawnDepths& depths);
  const DrawnDepths& depths() const { return depths_; }
  /// The record of a point of the grid at level depths().grid(). REQUIRES: the face's own grid has
  /// the point, or the point is on a side and the grid at the depth of the side has it.
  std::span<const std::byte> at(FacePoint point) const;
  template <class Record>
  const Record& at(FacePoint point) const {
    return *reinterpret_cast<const Record*>(at(point).data());
  }

 private:
  struct Read {
    PatchView patch;
    RecordView records;
  };
  /// A face across a side, read as deep as the side.
  struct Beyond {
    Read read;
    int side;
  };
  Read read_patch(FaceId face, int refinements) const;

  std::string attribute_;
  Reader reader_;
  Topology mesh_;
  int base_level_;
  DrawnDepths depths_;
  std::optional<Read> own_;
  std::array<std::optional<Beyond>, 3> beyond_;  ///< [side]
};

PLAIT_END_NAMESPACE
