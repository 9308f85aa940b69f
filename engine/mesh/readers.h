// readers.h: one reader per file format, and what they share. Each reads an Input from its start
// to its end and checks every number and index as it comes, so that messages can say where.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "input.h"
#include "plait/mesh_io.h"

namespace plait {

using Warnings = std::vector<std::string>;

IndexedMesh read_ply(Input& input, Warnings* warnings);
IndexedMesh read_obj(Input& input, Warnings* warnings);
IndexedMesh read_off(Input& input, Warnings* warnings);

/// Whether a file's first word is one of OFF's: OFF with any of the prefixes ST, C, N, 4, n.
bool is_off_keyword(std::string_view word);

/// Collects faces corner by corner, as fans of triangles around each face's first corner. A face
/// of a million corners needs no more memory than its triangles.
class FaceFans {
 public:
  explicit FaceFans(std::vector<std::array<VertexId, 3>>& triangles) : triangles_(triangles) {}

  void begin() { corners_ = 0; }
  /// False if there are now more triangles than a base mesh can have.
  bool add(VertexId vertex);
  std::uint64_t corners() const { return corners_; }  ///< of this face, so far

  void report(const Input& input, Warnings* warnings) const;

 private:
  std::vector<std::array<VertexId, 3>>& triangles_;
  std::uint64_t corners_ = 0;
  std::uint64_t polygons_ = 0;  ///< faces of more than three corners
  VertexId first_ = 0, previous_ = 0;
};

}  // namespace plait
