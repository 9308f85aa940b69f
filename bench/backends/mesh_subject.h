// bench/backends/mesh_subject.h: a mesh of the user's as the base mesh of what is measured.
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
/// others. With `chosen`, the levels are as many, up to `levels` and at least one, as take at most
/// `most_bytes`, and `chosen` gets their number. Errors: those of read_base_mesh().
MeshSubject mesh_subject(const std::filesystem::path& file, int levels,
                         std::uint64_t most_bytes = ~std::uint64_t{0}, int* chosen = nullptr);

}  // namespace plait::bench
