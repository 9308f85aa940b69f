// mesh_files.h: writes meshes as bytes of every format, compresses them, and makes files of them.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "plait/error.h"
#include "plait/mesh_io.h"
#include "support/temporary_directory.h"

namespace plait::mesh_files {

/// A directory for mesh files.
class MeshDirectory : public test::TemporaryDirectory {
 public:
  /// Makes a new file each time, which is faster: ext4 writes a file to the disk at once if it was
  /// truncated and rewritten.
  std::filesystem::path file(const std::string& name, const std::string& bytes) const {
    std::filesystem::remove(path() / name);
    std::ofstream(path() / name, std::ios::binary) << bytes;
    return path() / name;
  }
  std::size_t file_count() const {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(path()), {}));
  }
};

std::string gzip(const std::string& bytes);
std::string zstd(const std::string& bytes);

template <class Number>
void append_number(std::string& bytes, Number number, bool big_endian = false) {
  std::string raw(sizeof(Number), '\0');
  std::memcpy(raw.data(), &number, sizeof(Number));
  if (big_endian) std::reverse(raw.begin(), raw.end());
  bytes += raw;
}

inline std::string ply_header(const std::string& format, std::size_t vertices, std::size_t faces) {
  std::ostringstream text;
  text << "ply\nformat " << format << " 1.0\ncomment a small mesh\nelement vertex " << vertices
       << "\nproperty float x\nproperty float y\nproperty float z\nelement face " << faces
       << "\nproperty list uchar int vertex_indices\nend_header\n";
  return text.str();
}

inline std::string ply_ascii(const IndexedMesh& mesh) {
  std::ostringstream text;
  text << ply_header("ascii", mesh.positions.size(), mesh.faces.size());
  for (const auto& p : mesh.positions) text << p.x << ' ' << p.y << ' ' << p.z << '\n';
  for (const auto& f : mesh.faces) text << "3 " << f[0] << ' ' << f[1] << ' ' << f[2] << '\n';
  return text.str();
}

inline std::string ply_binary(const IndexedMesh& mesh, bool big_endian) {
  std::string bytes = ply_header(big_endian ? "binary_big_endian" : "binary_little_endian",
                                 mesh.positions.size(), mesh.faces.size());
  for (const auto& p : mesh.positions)
    for (int axis = 0; axis < 3; ++axis)
      append_number(bytes, static_cast<float>(p[axis]), big_endian);
  for (const auto& f : mesh.faces) {
    append_number(bytes, std::uint8_t{3});
    for (const VertexId vertex : f) append_number(bytes, vertex, big_endian);
  }
  return bytes;
}

inline std::string obj(const IndexedMesh& mesh) {
  std::ostringstream text;
  text << "# a small mesh\no shape\n";
  for (const auto& p : mesh.positions) text << "v " << p.x << ' ' << p.y << ' ' << p.z << '\n';
  for (const auto& f : mesh.faces)
    text << "f " << f[0] + 1 << ' ' << f[1] + 1 << "/1 " << f[2] + 1 << "//2\n";
  return text.str();
}

inline std::string off(const IndexedMesh& mesh) {
  std::ostringstream text;
  text << "OFF\n# a small mesh\n" << mesh.positions.size() << ' ' << mesh.faces.size() << " 0\n";
  for (const auto& p : mesh.positions) text << p.x << ' ' << p.y << ' ' << p.z << '\n';
  for (const auto& f : mesh.faces) text << "3 " << f[0] << ' ' << f[1] << ' ' << f[2] << '\n';
  return text.str();
}

struct Sample {
  std::string name;
  std::string bytes;
  bool ascii;
};

/// One mesh in every format.
inline std::vector<Sample> samples(const IndexedMesh& mesh) {
  return {{"ascii.ply", ply_ascii(mesh), true},
          {"little.ply", ply_binary(mesh, false), false},
          {"big.ply", ply_binary(mesh, true), false},
          {"text.obj", obj(mesh), true},
          {"text.off", off(mesh), true}};
}

inline bool same_mesh(const IndexedMesh& a, const IndexedMesh& b) {
  return a.positions == b.positions && a.faces == b.faces;
}

}  // namespace plait::mesh_files
