// tests/fuzz/small_levels.h: levels of tiny meshes in memory, in blocks of about 1 KiB, with the
// surroundings that filters need to predict one block from others.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "input_bytes.h"
#include "plait/base_mesh.h"
#include "plait/extend/filter.h"
#include "plait/extend/store_access.h"
#include "plait/registry.h"
#include "plait/store.h"
#include "plait/subdivide.h"

namespace plait::fuzz {

/// Closed and with border; with regular vertices and others.
inline constexpr std::size_t kSmallMeshes = 3;
/// After these: faces that have 0 to 4 levels.
inline constexpr std::size_t kMeshWithDepths = 3;
inline const BaseMesh& small_mesh(std::size_t number) {
  static const auto octahedron = [] {
    return BaseMesh::build(
        {{{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
         {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}, {1, 0, 5}, {2, 1, 5}, {3, 2, 5}, {0, 3, 5}}});
  }();
  static const auto tetrahedron = [] {
    return BaseMesh::build({{{1, 1, 1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}},
                            {{0, 1, 3}, {0, 2, 1}, {0, 3, 2}, {1, 2, 3}}});
  }();
  static const auto sheet = [] {
    IndexedMesh mesh;
    constexpr VertexId kSide = 4;
    for (VertexId y = 0; y < kSide; ++y)
      for (VertexId x = 0; x < kSide; ++x)
        mesh.positions.push_back({double(x), double(y), 0.25 * double((x * y) % 3)});
    for (VertexId y = 0; y + 1 < kSide; ++y)
      for (VertexId x = 0; x + 1 < kSide; ++x) {
        const VertexId at = y * kSide + x;
        mesh.faces.push_back({at, at + 1, at + kSide + 1});
        mesh.faces.push_back({at, at + kSide + 1, at + kSide});
      }
    return BaseMesh::build(std::move(mesh));
  }();
  static const auto deep = [] {
    std::vector<std::uint8_t> depths(sheet.face_count());
    for (std::size_t face = 0; face < depths.size(); ++face)
      depths[face] = static_cast<std::uint8_t>(face * face % 11 % 5);
    depths.front() = 4;
    return sheet.with_depths(std::move(depths));
  }();
  if (number == kMeshWithDepths) return deep;
  return number == 0 ? octahedron : number == 1 ? tetrahedron : sheet;
}

class SmallLevels {
 public:
  static constexpr int kFinest = 4;
  static constexpr std::uint64_t kBlockBytes = 1024;

  /// All bytes are zero. The mesh outlives the object, which does not move. Attributes have the
  /// numbers 0, 1, ...
  SmallLevels(const BaseMesh& mesh, const std::vector<AttributeSchema>& schemas) : mesh_(mesh) {
    for (const AttributeSchema& schema : schemas) {
      auto attribute = std::make_unique<Attribute>();
      attribute->base.resize(mesh.vertex_count() * schema.record_bytes());
      AttributeLevels known{
          static_cast<std::uint32_t>(attributes_.size()), schema, attribute->base, {}};
      for (int level = 1; level <= kFinest; ++level) {
        attribute->geometries.push_back(std::make_unique<LevelGeometry>(
            mesh.geometry(BaseRelativeLevel(level), schema.record_bytes(), kBlockBytes)));
        attribute->levels.emplace_back(attribute->geometries.back()->total_bytes());
        known.levels.push_back(attribute->geometries.back().get());
      }
      attributes_.push_back(std::move(attribute));
      surroundings_.attributes.push_back(std::move(known));
    }
    surroundings_.mesh = mesh.topology();
    surroundings_.depths = mesh.depths();
    surroundings_.positions = mesh.positions();
  }
  SmallLevels(const SmallLevels&) = delete;
  SmallLevels& operator=(const SmallLevels&) = delete;

  const BaseMesh& mesh() const { return mesh_; }
  const AttributeSchema& schema(std::size_t attribute) const {
    return surroundings_.attributes[attribute].schema;
  }
  const LevelGeometry& geometry(std::size_t attribute, int level) const {
    return *attributes_[attribute]->geometries[static_cast<std::size_t>(level - 1)];
  }
  std::span<std::byte> base(std::size_t attribute) { return attributes_[attribute]->base; }
  std::span<std::byte> bytes(std::size_t attribute, int level) {
    return attributes_[attribute]->levels[static_cast<std::size_t>(level - 1)];
  }
  std::span<std::byte> block(std::size_t attribute, int level, std::uint64_t block) {
    const LevelGeometry& where = geometry(attribute, level);
    return bytes(attribute, level).subspan(where.block_offset(block), where.block_bytes(block));
  }
  FilterLevel filter_level(std::size_t attribute, int level) const {
    return {schema(attribute), &geometry(attribute, level), static_cast<std::uint32_t>(attribute),
            level, &surroundings_};
  }

 private:
  struct Attribute {
    std::vector<std::byte> base;
    std::vector<std::unique_ptr<LevelGeometry>> geometries;  ///< [level - 1]
    std::vector<std::vector<std::byte>> levels;
  };

  const BaseMesh& mesh_;
  std::vector<std::unique_ptr<Attribute>> attributes_;
  LevelSurroundings surroundings_;
};

/// Positions of this precision, and normals: what Loop's rule makes of the mesh.
inline std::unique_ptr<SmallLevels> refined_levels(const BaseMesh& mesh, ComponentType precision) {
  auto levels = std::make_unique<SmallLevels>(
      mesh, std::vector<AttributeSchema>{{"position", precision, 3},
                                         {"normal", ComponentType::kFloat32, 3}});
  StoreOptions options;
  options.backend = "memory";
  Store store = Store::create({}, mesh, options, default_backends());
  add_base_positions(store, precision);
  SubdivideOptions how;
  how.levels = SmallLevels::kFinest;
  how.normals = true;
  subdivide(store, how);
  for (AttributeId id = 0; id < 2; ++id) {
    const AttributeId from = store.attribute(levels->schema(id).name);
    std::ranges::copy(std::as_const(store).base_bytes(from), levels->base(id).begin());
    for (int level = 1; level <= SmallLevels::kFinest; ++level) {
      const LevelFile& file = StoreAccess::level_file(std::as_const(store), from, level);
      Session session = StoreAccess::open_session(store);
      for (std::uint64_t block = 0; block < file.geometry.block_count(); ++block) {
        const PinnedBlock pinned = session.pin(file, block);
        const std::span<const std::byte> raw = pinned.bytes();
        std::ranges::copy(
            raw, levels->bytes(id, level).subspan(file.geometry.block_offset(block)).begin());
      }
    }
  }
  return levels;
}

/// The context of a block, each of its blocks in memory of exactly its size.
class ContextBytes {
 public:
  ContextBytes() = default;
  ContextBytes(const Filter& filter, SmallLevels& levels, std::uint64_t block) {
    std::array<ContextBlock, kMostContextBlocks> needed;
    const std::size_t count = filter.context(block, needed);
    for (const ContextBlock& each : std::span(needed).first(count))
      copies_.emplace_back(levels.block(each.attribute, each.level, each.block));
    for (ExactBytes& copy : copies_) spans_.push_back(copy.span());
  }
  std::span<const std::span<const std::byte>> spans() const { return spans_; }

 private:
  std::vector<ExactBytes> copies_;
  std::vector<std::span<const std::byte>> spans_;
};

}  // namespace plait::fuzz
