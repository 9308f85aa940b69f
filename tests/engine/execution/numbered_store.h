// tests/engine/execution/numbered_store.h: stores whose records hold the number of their vertex in
// a mesh that a naive subdivision refined.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "engine/store/sample_store.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/sweep.h"
#include "plait/registry.h"
#include "support/naive_subdivision.h"
#include "support/temporary_directory.h"

namespace plait::test {

inline constexpr int kLevels = 3;
inline constexpr std::int64_t kSize = 1 << kLevels;

/// So large that a face needs many blocks.
struct Wide {
  std::uint32_t vertex, rest[31];
};

}  // namespace plait::test

namespace plait {
template <>
struct RecordTraits<test::Wide> {
  static constexpr ComponentType kType = ComponentType::kUint32;
  static constexpr std::uint32_t kComponents = 32;
};
}  // namespace plait

namespace plait::test {

/// Weights at the corners of a face; the lattice point (i, j) is the last two.
struct Weighted {
  FaceId face;
  std::array<std::int64_t, 3> k;
};

/// The refined mesh as the naive subdivision numbers its vertices.
class Expected {
 public:
  explicit Expected(const BaseMesh& base)
      : base_(base), oracle_(naive::subdivide(mesh_of(base), naive::Scheme::kMidpoint, kLevels)) {
    for (FaceId face = 0; face < base.face_count(); ++face)
      for (std::size_t corner = 0; corner < 3; ++corner)
        face_of_[{base.faces()[face][corner], base.faces()[face][(corner + 1) % 3]}] = face;
  }

  /// The vertex at a point of the face or of what unfolds beyond it; kNone beyond a border.
  std::uint32_t vertex(Weighted point) const {
    while (true) {
      const auto negative = std::ranges::find_if(point.k, [](std::int64_t k) { return k < 0; });
      if (negative == point.k.end())
        return naive::vertex_at(oracle_, point.face, point.k[1], point.k[2]);
      const auto x = static_cast<std::size_t>(negative - point.k.begin());
      const VertexId p = base_.faces()[point.face][(x + 1) % 3];
      const VertexId q = base_.faces()[point.face][(x + 2) % 3];
      const auto beyond = face_of_.find({q, p});
      if (beyond == face_of_.end()) return naive::kNone;
      // The two faces as a parallelogram: the corner x is p + q - r for the corner r beyond.
      Weighted there{beyond->second, {-point.k[x], -point.k[x], -point.k[x]}};
      for (std::size_t corner = 0; corner < 3; ++corner) {
        if (base_.faces()[there.face][corner] == p)
          there.k[corner] = point.k[(x + 1) % 3] + point.k[x];
        if (base_.faces()[there.face][corner] == q)
          there.k[corner] = point.k[(x + 2) % 3] + point.k[x];
      }
      point = there;
    }
  }
  /// Triangles of the finest level. A base face f has triangles f 4^kLevels to (f + 1) 4^kLevels
  /// - 1.
  const std::vector<naive::Triangle>& triangles() const { return oracle_.triangles; }
  bool has_border(FaceId face, int side) const {
    const auto& corners = base_.faces()[face];
    const auto x = static_cast<std::size_t>(side);
    return !face_of_.contains({corners[(x + 2) % 3], corners[(x + 1) % 3]});
  }

  /// Slots of a level, of which each record holds its vertex.
  std::vector<Wide> level(int number) const {
    std::vector<Wide> records;
    const std::int64_t n = slot_side(number);
    for (EdgeId edge = 0; edge < base_.edge_count(); ++edge)
      for (std::int64_t row = 0; row < n; ++row)
        for (std::int64_t column = 0; column < (base_.edges()[edge].is_border() ? n - row : n);
             ++column) {
          const FaceIndex at =
              at_level(face_index(base_.topology(), {edge, number, row, column}), kLevels);
          records.push_back({naive::vertex_at(oracle_, at.face, at.i, at.j), {}});
        }
    return records;
  }

 private:
  static naive::Mesh mesh_of(const BaseMesh& base) {
    naive::Mesh mesh;
    for (const Vector3<double>& p : base.positions()) mesh.points.push_back({p.x, p.y, p.z});
    mesh.triangles.assign(base.faces().begin(), base.faces().end());
    return mesh;
  }

  const BaseMesh& base_;
  naive::Mesh oracle_;
  std::map<std::pair<VertexId, VertexId>, FaceId> face_of_;
};

/// A committed store whose records hold their vertices.
struct OnDisk {
  OnDisk(const std::string& backend, const BaseMesh& base, int base_level = 0) : expected(base) {
    StoreOptions options = sample_options(backend);
    options.budget_bytes = 64 << 20;
    Store store =
        Store::create(path, base, options, default_backends(), {.base_level = base_level});
    const AttributeId id = store.add_attribute(schema_of<Wide>("vertex"));
    for (VertexId v = 0; v < base.vertex_count(); ++v) store.base_records<Wide>(id)[v] = {v, {}};
    for (int level = 1; level <= kLevels; ++level) {
      store.add_level(id);
      const std::vector<Wide> records = expected.level(level);
      write_level(store, id, base_level + level, std::as_bytes(std::span(records)));
    }
    store.commit();
  }
  Store open(std::uint64_t budget_bytes = 64 << 20, bool writable = false) const {
    return Store::open(path, {.writable = writable, .budget_bytes = budget_bytes},
                       default_backends());
  }
  Expected expected;
  TemporaryDirectory directory{Medium::kMemory};
  std::filesystem::path path = directory.path() / "s.plait";
};

}  // namespace plait::test
