// A prototype of adaptive depth: every face is refined to a depth of its own. The shapes of the
// slots follow from the depths, and nothing else changes: LevelGeometry places the slots without a
// gap, a patch table finds every vertex of every face in them, and the grid of an edge gets the
// vertices of both of its faces. See docs/adaptive.md.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cstring>
#include <random>
#include <set>
#include <vector>

#include "plait/base_mesh.h"
#include "plait/detail/edge_grid.h"
#include "plait/detail/patch_table.h"
#include "plait/extend/level_geometry.h"
#include "plait/extend/vertex_numbering.h"
#include "support/test_meshes.h"

namespace plait {
namespace {

using namespace plait::test;

constexpr int kMostDepth = 5;
constexpr std::uint32_t kUnused = kNoId;

/// How many faces of an edge have a level decides the shape of its slot there.
SlotShape shape_of(const Edge& edge, const std::vector<int>& depths, int level) {
  const int faces = static_cast<int>(depths[edge.own.face()] >= level) +
                    static_cast<int>(!edge.is_border() && depths[edge.other.face()] >= level);
  return faces == 2 ? SlotShape::kWhole : faces == 1 ? SlotShape::kHalf : SlotShape::kAbsent;
}

SlotShapes shapes_at(const BaseMesh& base, const std::vector<int>& depths, int level) {
  std::vector<EdgeId> half, absent;
  for (EdgeId edge = 0; edge < base.edge_count(); ++edge) {
    const SlotShape shape = shape_of(base.edges()[edge], depths, level);
    if (shape == SlotShape::kHalf) half.push_back(edge);
    if (shape == SlotShape::kAbsent) absent.push_back(edge);
  }
  return {base.edge_count(), EdgeSet(half), EdgeSet(absent)};
}

/// The levels of one attribute whose records hold the numbers of their vertices.
class AdaptiveLevels {
 public:
  AdaptiveLevels(const BaseMesh& base, const std::vector<int>& depths, std::uint64_t block_bytes)
      : base_(base), depths_(depths), numbering_(base.topology(), kMostDepth) {
    base_records_.assign(base.vertex_count(), kUnused);
    for (int level = 1; level <= kMostDepth; ++level) {
      geometry_.emplace_back(shapes_at(base, depths, level), BaseRelativeLevel(level),
                             sizeof(std::uint32_t), block_bytes);
      records_.emplace_back(geometry_.back().total_bytes() / sizeof(std::uint32_t), kUnused);
    }
  }

  const LevelGeometry& geometry(int level) const {
    return geometry_[static_cast<std::size_t>(level - 1)];
  }
  std::vector<std::uint32_t>& records(int level) {
    return records_[static_cast<std::size_t>(level - 1)];
  }

  std::span<const std::uint32_t> base_records() const { return base_records_; }
  SlotRecords<const std::uint32_t> slot(int level, EdgeId edge) const {
    const Slot slot = geometry(level).slot(edge);
    return {std::span(records_[static_cast<std::size_t>(level - 1)])
                .subspan(slot.offset / sizeof(std::uint32_t), slot.bytes / sizeof(std::uint32_t)),
            slot.shape};
  }
  /// The number of a vertex in the mesh in which all faces have all levels.
  std::uint32_t vertex(const FaceIndex& point) const {
    return static_cast<std::uint32_t>(numbering_.number(at_level(point, kMostDepth)));
  }

  /// Stores the number of every vertex of the face through a patch table.
  /// False: a record holds another vertex already.
  bool write(FaceId face) {
    const int depth = depths_[face];
    PatchTable table;
    table.set_levels(0, BaseRelativeLevel(depth));
    table.enter(base_.topology(), face, sizeof(std::uint32_t), false,
                reinterpret_cast<std::byte*>(base_records_.data()),
                [&](EdgeId edge, BaseRelativeLevel level) {
                  const Slot slot = geometry(level.refinements).slot(edge);
                  return LocatedSlot{std::as_writable_bytes(std::span(records(level.refinements)))
                                         .subspan(slot.offset, slot.bytes),
                                     slot.shape};
                });
    bool right = true;
    const std::int64_t size = std::int64_t{1} << depth;
    for (std::int64_t j = 0; j <= size; ++j)
      for (std::int64_t i = 0; i + j <= size; ++i) {
        const std::uint32_t vertex = this->vertex({face, depth, i, j});
        auto& record = *reinterpret_cast<std::uint32_t*>(table.inside(depth, i, j));
        right &= record == kUnused || record == vertex;
        record = vertex;
      }
    return right;
  }

 private:
  const BaseMesh& base_;
  const std::vector<int>& depths_;
  VertexNumbering numbering_;
  std::vector<std::uint32_t> base_records_;
  std::vector<LevelGeometry> geometry_;              ///< [level - 1]
  std::vector<std::vector<std::uint32_t>> records_;  ///< [level - 1]
};

/// Whether the grid of an edge, gathered as far as both of its faces have levels, has the right
/// vertices at all points. REQUIRES: every vertex was written.
bool grid_is_right(const BaseMesh& base, const std::vector<int>& depths, AdaptiveLevels& levels,
                   EdgeId edge) {
  const Edge& at = base.edges()[edge];
  int level = depths[at.own.face()];
  if (!at.is_border()) level = std::min(level, depths[at.other.face()]);
  EdgeGrid<std::uint32_t> grid;
  grid.resize(level);
  const std::int64_t size = grid.size();
  std::fill_n(grid.at(-1, -1), grid.shape().point_count(), kUnused);
  gather(base.topology(), levels, levels.base_records(), edge, {0, level}, grid);
  bool right = true;
  for (std::int64_t p = 0; p <= size; ++p)
    for (std::int64_t q = 0; q <= size; ++q) {
      const bool turned = p + q > size;
      const FaceSide side = turned ? at.other : at.own;
      if (!side.exists()) continue;
      std::array<std::int64_t, 3> weights{};
      const auto corner = [&](int turn) -> std::int64_t& {
        return weights[static_cast<std::size_t>((side.side() + turn) % 3)];
      };
      corner(1) = turned ? size - p : p;
      corner(2) = turned ? size - q : q;
      corner(0) = size - corner(1) - corner(2);
      right &= *grid.at(p, q) == levels.vertex({side.face(), level, weights[1], weights[2]});
    }
  return right;
}

/// Offsets, blocks and totals against a sum over the edges.
void check_geometry(const LevelGeometry& geometry, const BaseMesh& base,
                    const std::vector<int>& depths) {
  const int level = geometry.level().refinements;
  const auto n = static_cast<std::uint64_t>(slot_side(level));
  std::uint64_t sum = 0;
  std::vector<std::uint64_t> block_bytes(geometry.block_count(), 0);
  for (EdgeId edge = 0; edge < base.edge_count(); ++edge) {
    const SlotShape shape = shape_of(base.edges()[edge], depths, level);
    const std::uint64_t bytes =
        geometry.record_bytes() * (shape == SlotShape::kWhole  ? n * n
                                   : shape == SlotShape::kHalf ? n * (n + 1) / 2
                                                               : 0);
    const Slot slot = geometry.slot(edge);
    REQUIRE(slot.shape == shape);
    REQUIRE(slot.offset == sum);
    REQUIRE(slot.bytes == bytes);
    sum += bytes;
    if (bytes == 0) continue;
    const std::uint64_t block = geometry.block_of(edge);
    REQUIRE(block < geometry.block_count());
    REQUIRE(geometry.first_edge(block) <= edge);
    REQUIRE(edge < geometry.edge_after(block));
    block_bytes[block] += bytes;
  }
  CHECK(geometry.total_bytes() == sum);
  for (std::uint64_t block = 0; block < geometry.block_count(); ++block) {
    REQUIRE(block_bytes[block] > 0);
    REQUIRE(geometry.block_bytes(block) == block_bytes[block]);
  }
}

std::vector<int> random_depths(const BaseMesh& base, std::mt19937& random) {
  std::vector<int> depths(base.face_count());
  // Neighbours seldom differ in one run and nearly always in another.
  const auto change_percent = random() % 100;
  int depth = 0;
  for (int& of_face : depths) {
    if (random() % 100 < change_percent) depth = static_cast<int>(random() % (kMostDepth + 1));
    of_face = depth;
  }
  return depths;
}

}  // namespace

TEST_CASE("AdaptiveDepth_RandomDepths_EveryVertexHasOneRecordAndEveryRecordAVertex") {
  std::mt19937 random(20);
  std::vector<NamedMesh> meshes = all_meshes();
  meshes.push_back({"random sphere", random_sphere(5, 60)});
  meshes.push_back({"random sheet", random_sheet(6, 60)});
  for (const NamedMesh& named : meshes)
    for (int turn = 0; turn < 6; ++turn) {
      INFO(named.name << ", turn " << turn);
      const BaseMesh base = BaseMesh::build(named.mesh);
      const std::vector<int> depths = random_depths(base, random);
      AdaptiveLevels levels(base, depths, std::uint64_t{64} << random() % 8);
      for (int level = 1; level <= kMostDepth; ++level)
        check_geometry(levels.geometry(level), base, depths);

      bool same_record_same_vertex = true;
      for (FaceId face = 0; face < base.face_count(); ++face)
        same_record_same_vertex &= levels.write(face);
      CHECK(same_record_same_vertex);
      bool grids_are_right = true;
      for (EdgeId edge = 0; edge < base.edge_count(); ++edge)
        grids_are_right &= grid_is_right(base, depths, levels, edge);
      CHECK(grids_are_right);
      std::set<std::uint32_t> vertices;
      std::uint64_t unused = 0, twice = 0;
      for (int level = 1; level <= kMostDepth; ++level)
        for (const std::uint32_t vertex : levels.records(level)) {
          unused += vertex == kUnused ? 1u : 0u;
          twice += vertices.insert(vertex).second ? 0u : 1u;
        }
      CHECK(unused == 0);
      CHECK(twice == 0);
    }
}

TEST_CASE("AdaptiveDepth_EqualDepths_AreTheLevelsOfToday") {
  for (const NamedMesh& named : all_meshes()) {
    INFO(named.name);
    const BaseMesh base = BaseMesh::build(named.mesh);
    const std::vector<int> depths(base.face_count(), kMostDepth);
    for (int level = 1; level <= kMostDepth; ++level) {
      const LevelGeometry adaptive(shapes_at(base, depths, level), BaseRelativeLevel(level), 12,
                                   4096);
      const LevelGeometry uniform = base.geometry(BaseRelativeLevel(level), 12, 4096);
      REQUIRE(adaptive.block_count() == uniform.block_count());
      REQUIRE(adaptive.total_bytes() == uniform.total_bytes());
      for (EdgeId edge = 0; edge < base.edge_count(); ++edge) {
        REQUIRE(adaptive.slot(edge).offset == uniform.slot(edge).offset);
        REQUIRE(adaptive.slot(edge).shape == uniform.slot(edge).shape);
        REQUIRE(adaptive.block_of(edge) == uniform.block_of(edge));
      }
    }
  }
}

}  // namespace plait
