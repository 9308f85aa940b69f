// mesh_source.h: how messages name a mesh and its faces.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "base/text.h"
#include "plait/base_mesh.h"
#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Refers to the name and the list that it got. Both must outlive the object.
class MeshSource {
 public:
  /// Implicit, because most meshes have a name and no polygons.
  // NOLINTNEXTLINE(google-explicit-constructor)
  MeshSource(std::string_view name, std::span<const CutFace> cut_faces = {})
      : name_(name), cut_faces_(cut_faces) {}
  // NOLINTNEXTLINE(google-explicit-constructor)
  MeshSource(const std::string& name) : name_(name) {}
  // NOLINTNEXTLINE(google-explicit-constructor)
  MeshSource(const char* name) : name_(name) {}

  /// How a message begins. Vertices and faces have the numbers of IndexedMesh, from 0; an OBJ file,
  /// which counts from 1, is told so.
  std::string name() const {
    const std::string text(name_);
    std::string ending = lower_extension(text);
    if (ending == ".gz" || ending == ".zst")
      ending = lower_extension(text.substr(0, text.size() - ending.size()));
    return ending == ".obj" ? text + ", counted from 0" : text;
  }
  /// The number that the file gives the face of which `triangle` is a part.
  std::uint64_t face(FaceId triangle) const {
    const auto after = std::ranges::upper_bound(cut_faces_, triangle, {}, &CutFace::first_triangle);
    if (after == cut_faces_.begin()) return triangle;
    const CutFace& before = *(after - 1);
    const FaceId behind = triangle - before.first_triangle;
    return before.number + (behind < before.triangles ? 0 : behind - before.triangles + 1);
  }
  /// How many faces the file has for this number of triangles.
  std::uint64_t face_count(std::uint64_t triangles) const {
    return triangles == 0 ? 0 : face(static_cast<FaceId>(triangles - 1)) + 1;
  }

 private:
  std::string_view name_;
  std::span<const CutFace> cut_faces_;
};

PLAIT_END_NAMESPACE
