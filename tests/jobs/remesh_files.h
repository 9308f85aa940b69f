// tests/jobs/remesh_files.h: a scan and the store that remesh() makes of it, in a directory of
// their own.
#pragma once

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <random>
#include <vector>

#include "plait/mesh_io.h"
#include "plait/reader.h"
#include "plait/registry.h"
#include "remesh/remesh.h"
#include "support/sanitized.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test {

struct RemeshFiles {
  TemporaryDirectory directory{Medium::kMemory};
  std::filesystem::path scan = directory.path() / "scan.ply", store = directory.path() / "s.plait";

  RemeshRequest request(std::uint64_t faces, int levels = 3) const {
    return {.scan = scan,
            .store = store,
            .faces = faces,
            .levels = levels,
            .report_samples = unless_sanitized(20000, 5000),
            .options = {.backend = "pread", .durability = Durability::kNone},
            .threads = 2,
            .existing = Existing::kReplace};
  }
  RemeshReport run(const RemeshRequest& request, const JobWatch& watch = {}) const {
    return remesh(request, default_backends(), watch);
  }
  RemeshReport run(const IndexedMesh& mesh, std::uint64_t faces, int levels = 3) const {
    write_ply(scan, mesh);
    return run(request(faces, levels));
  }
  Store open() const { return Store::open(store, {}, default_backends()); }
};

/// A PLY file in which a number of each vertex follows from its position.
inline void write_with_attributes(const std::filesystem::path& path, const IndexedMesh& mesh) {
  std::ofstream file(path);
  file << "ply\nformat ascii 1.0\nelement vertex " << mesh.positions.size()
       << "\nproperty float x\nproperty float y\nproperty float z\nproperty float nx\nproperty "
          "float ny\nproperty float nz\nproperty uchar red\nproperty uchar green\nproperty uchar "
          "blue\nproperty double height\nproperty int label\nproperty uchar turned\nelement face "
       << mesh.faces.size() << "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const Vector3<double>& p : mesh.positions)
    file << p.x << ' ' << p.y << ' ' << p.z << " 0 3 4 " << std::lround(std::abs(p.x)) << ' '
         << std::lround(std::abs(p.y)) << " 7 " << 2 * p.x - p.y << ' ' << (p.x < 10 ? -5 : 9)
         << " 1\n";
  for (const auto& f : mesh.faces) file << "3 " << f[0] << ' ' << f[1] << ' ' << f[2] << '\n';
}

inline IndexedMesh with_noise(IndexedMesh mesh, double amplitude) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> number(-amplitude, amplitude);
  for (Vector3<double>& p : mesh.positions)
    p = p + Vector3<double>{number(random), number(random), number(random)};
  return mesh;
}

inline IndexedMesh flat_sheet(std::uint32_t columns, std::uint32_t rows) {
  IndexedMesh mesh = sheet(columns, rows);
  for (Vector3<double>& p : mesh.positions) p.z = 0;
  return mesh;
}

/// Calls visit(patch) for each face at the finest level.
template <class Visit>
void for_each_patch(const Store& store, Visit visit) {
  const Reader reader(store);
  for (FaceId face = 0; face < store.base().face_count(); ++face)
    visit(reader.read_patch(face, store.finest_level()));
}

inline bool keeps_topology(const RemeshReport& report) {
  return report.base.euler_number == report.scan.euler_number &&
         report.base.components == report.scan.components &&
         report.base.borders == report.scan.borders;
}

}  // namespace plait::test
