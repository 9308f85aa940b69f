// readers.h: one reader per file format, and their common parts. Each reader reads an Input from
// start to end. It checks every number and index when it reads it, so that messages can name the
// place.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "mesh/files/input.h"
#include "plait/extend/attributed_mesh.h"
#include "plait/mesh_io.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

using Warnings = std::vector<std::string>;

IndexedMesh read_ply(Input& input, Warnings* warnings);
IndexedMesh read_obj(Input& input, Warnings* warnings);
IndexedMesh read_off(Input& input, Warnings* warnings);
IndexedMesh read_stl(Input& input, Warnings* warnings);
AttributedMesh read_ply_with_attributes(Input& input, Warnings* warnings);

/// Whether a word begins an OFF file: OFF, with any of the prefixes ST, C, N, 4, n.
bool is_off_keyword(std::string_view word);

/// Takes faces corner by corner, and divides each into triangles around the face's first corner. It
/// does not store corners, so a face of a million corners needs only the memory of its triangles.
class FaceDivider {
 public:
  explicit FaceDivider(std::vector<std::array<VertexId, 3>>& triangles) : triangles_(triangles) {}

  void begin() { corners_ = 0; }
  /// Returns false if there are now more triangles than a base mesh can have.
  bool add(VertexId vertex);
  std::uint64_t corners() const { return corners_; }  ///< of the current face, so far

  void report(const Input& input, Warnings* warnings) const;

 private:
  std::vector<std::array<VertexId, 3>>& triangles_;
  std::uint64_t corners_ = 0;
  std::uint64_t polygons_ = 0;  ///< faces of more than three corners
  VertexId first_ = 0, previous_ = 0;
};

PLAIT_END_NAMESPACE
