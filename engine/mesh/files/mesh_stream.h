// mesh_stream.h: reads a mesh file of any size, in parts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "plait/base_mesh.h"
#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Who gets the vertices and faces of a file, in its order.
class MeshSink {
 public:
  static constexpr std::size_t kPart = std::size_t{1} << 16;

  virtual ~MeshSink() = default;
  /// What the header promises; before all parts.
  virtual void begin(std::uint64_t vertex_count, std::uint64_t face_count) = 0;
  /// Vertices and faces; up to a little more than kPart of each.
  virtual void take(const IndexedMesh& part) = 0;
};

/// Gives the file to `sink`: ascii and binary PLY, also .gz and .zst. All corners are below the
/// number of vertices, all positions are finite. Errors: those of read_base_mesh() for what the
/// file says; kNotSupported for another format and for a face of more than three corners.
void stream_mesh(const std::filesystem::path& path, MeshSink& sink,
                 std::vector<std::string>* warnings);

PLAIT_END_NAMESPACE
