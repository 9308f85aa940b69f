// bench/mesh_subject.h: a mesh of the user's as the base mesh of what is measured.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace plait::bench {

struct MeshSubject {
  std::filesystem::path file;
  /// "spot.ply 1a2b3c4d5e6f7081": the file's name, and the checksum of positions and faces, so that
  /// records of different meshes never have the same key.
  std::string name;
  std::uint64_t base_vertices = 0;
  std::uint64_t vertices = 0;  ///< at the finest level
};

/// Reads the mesh in a process of its own, because reading uses threads and this process starts
/// others. Errors: those of read_base_mesh().
MeshSubject mesh_subject(const std::filesystem::path& file, int levels);

}  // namespace plait::bench
