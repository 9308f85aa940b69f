// Face index <-> edge index, judged by what a vertex is: the base vertices or base edge or base
// face that it lies on, and its weights there. Two face indices are the same vertex exactly when
// these agree.
#include "plait/extend/edge_index.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <random>
#include <vector>

#include "naive_topology.h"
#include "support/test_meshes.h"

using namespace plait;

namespace {

/// What a refined vertex is, whichever face it is looked at from.
struct Identity {
  VertexId low = kNoId, high = kNoId;  ///< the base edge it lies on, or
  FaceId face = kNoId;                 ///< the base face it lies inside
  std::int64_t first = 0, second = 0;  ///< weights of low and high, or of corners 1 and 2
  friend bool operator==(const Identity&, const Identity&) = default;
};

/// With weights out of 2^kMaxLevel, so that all levels compare.
Identity identity(const Topology& mesh, const FaceIndex& point) {
  const FaceIndex fine = at_level(point, kMaxLevel);
  const std::array<std::int64_t, 3> weights{(std::int64_t{1} << kMaxLevel) - fine.i - fine.j,
                                            fine.i, fine.j};
  const auto& corners = mesh.faces[point.face];
  for (std::size_t x = 0; x < 3; ++x) {
    if (weights[x] != 0) continue;
    const std::size_t p = (x + 1) % 3, q = (x + 2) % 3;
    return corners[p] < corners[q]
               ? Identity{corners[p], corners[q], kNoId, weights[p], weights[q]}
               : Identity{corners[q], corners[p], kNoId, weights[q], weights[p]};
  }
  return {kNoId, kNoId, point.face, weights[1], weights[2]};
}

bool is_inside(const FaceIndex& point) {
  return point.i >= 0 && point.j >= 0 && point.i + point.j <= std::int64_t{1} << point.level;
}

SlotShape shape_of(const Edge& edge) {
  return edge.is_border() ? SlotShape::kHalf : SlotShape::kWhole;
}

/// [edge] records of a level before the edge's slot; one more for the end.
std::vector<std::uint64_t> slot_begins(const Topology& mesh, int level) {
  std::vector<std::uint64_t> begins{0};
  for (const Edge& edge : mesh.edges)
    begins.push_back(begins.back() + slot_records(level, shape_of(edge)));
  return begins;
}

/// Calls visit(point) for every point of every face at `level` but the corners.
template <class Visit>
void for_each_point(const Topology& mesh, int level, Visit visit) {
  const std::int64_t size = std::int64_t{1} << level;
  for (FaceId face = 0; face < mesh.faces.size(); ++face)
    for (std::int64_t i = 0; i <= size; ++i)
      for (std::int64_t j = 0; i + j <= size; ++j)
        if (!is_corner(level, i, j)) visit(FaceIndex{face, level, i, j});
}

/// A face index of any level up to kMaxLevel that is no corner, near borders of the face (where
/// mistakes live) as often as deep inside.
FaceIndex random_point(const Topology& mesh, std::mt19937_64& random) {
  const auto below = [&](std::int64_t count) {
    return static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(count));
  };
  while (true) {
    const int level = 1 + static_cast<int>(below(kMaxLevel));
    const std::int64_t size = std::int64_t{1} << level;
    std::int64_t weights[3];
    weights[0] = below(4) == 0 ? below(std::min<std::int64_t>(size, 3) + 1) : below(size + 1);
    weights[1] = below(size - weights[0] + 1);
    weights[2] = size - weights[0] - weights[1];
    const auto turn = static_cast<std::size_t>(below(3));
    const FaceIndex point{static_cast<FaceId>(below(static_cast<std::int64_t>(mesh.faces.size()))),
                          level, weights[(1 + turn) % 3], weights[(2 + turn) % 3]};
    if (!is_corner(level, point.i, point.j)) return point;
  }
}

}  // namespace

TEST_CASE("EdgeIndex_EveryPointThroughLevelSix_FillsEverySlotOnce") {
  for (const auto& [name, indexed] : test::all_meshes()) {
    INFO(name);
    const test::NaiveTopology topology(indexed);
    const Topology mesh = topology.view();
    for (int finest = 1; finest <= 6; ++finest) {
      std::vector<std::vector<std::uint64_t>> begins(1);
      std::vector<std::vector<Identity>> stored(1);
      std::uint64_t records = 0;
      for (int level = 1; level <= finest; ++level) {
        begins.push_back(slot_begins(mesh, level));
        stored.emplace_back(begins.back().back());
        records += begins.back().back();
      }
      // Slots of all levels = vertices that refinement adds: V' = V + E, E' = 2E + 3F, F' = 4F.
      std::uint64_t vertices = 0, edges = mesh.edges.size(), faces = mesh.faces.size();
      for (int level = 1; level <= finest; ++level) {
        vertices += edges;
        edges = 2 * edges + 3 * faces;
        faces *= 4;
      }
      REQUIRE(records == vertices);

      std::uint64_t filled = 0;
      for_each_point(mesh, finest, [&](const FaceIndex& point) {
        const EdgeIndex at = edge_index(mesh, point);
        const std::int64_t n = slot_side(at.level);
        const SlotShape shape = shape_of(mesh.edges[at.edge]);
        const bool in_range = at.level >= 1 && at.level <= finest && at.row >= 0 && at.row < n &&
                              at.column >= 0 && at.column < row_records(shape, n, at.row);
        if (!in_range) FAIL("face " << point.face << " (" << point.i << ", " << point.j << ")");
        const auto position = static_cast<std::size_t>(
            begins[static_cast<std::size_t>(at.level)][at.edge] +
            static_cast<std::uint64_t>(slot_position(at.level, shape, at.row, at.column)));
        Identity& there = stored[static_cast<std::size_t>(at.level)][position];
        const Identity here = identity(mesh, point);
        // As many records as vertices, each filled and by one vertex only: a bijection.
        filled += there == Identity{};
        if (!(there == Identity{} || there == here))
          FAIL("two vertices at edge " << at.edge << " row " << at.row << " column " << at.column);
        there = here;
        const FaceIndex back = face_index(mesh, at);
        if (!is_inside(back) || back.level != at.level || !(identity(mesh, back) == here))
          FAIL("no way back from edge " << at.edge << " row " << at.row << " column " << at.column);
      });
      REQUIRE(filled == records);
    }
  }
}

TEST_CASE("FaceIndex_EveryRecordThroughLevelSix_ComesBackToItself") {
  for (const auto& [name, indexed] : test::all_meshes()) {
    INFO(name);
    const test::NaiveTopology topology(indexed);
    const Topology mesh = topology.view();
    std::size_t compared = 0;
    for (int level = 1; level <= 6; ++level) {
      const std::int64_t n = slot_side(level);
      for (EdgeId edge = 0; edge < mesh.edges.size(); ++edge) {
        const bool border = mesh.edges[edge].is_border();
        for (std::int64_t row = 0; row < n; ++row) {
          for (std::int64_t column = 0; column < (border ? n - row : n); ++column, ++compared) {
            const EdgeIndex at{edge, level, row, column};
            const FaceIndex point = face_index(mesh, at);
            if (!is_inside(point) || !(edge_index(mesh, point) == at))
              FAIL("edge " << edge << " level " << level << " row " << row << " column " << column);
          }
        }
      }
    }
    // At least border slots at levels 1 to 6: 1 + 3 + 10 + 36 + 136 + 528 records.
    CHECK(compared >= 714 * mesh.edges.size());
  }
}

TEST_CASE("EdgeIndex_Frame_RunsFromTheEdgesStartToItsEndInItsOwnFace") {
  for (const auto& [name, indexed] : test::all_meshes()) {
    INFO(name);
    const test::NaiveTopology topology(indexed);
    const Topology mesh = topology.view();
    for (EdgeId e = 0; e < mesh.edges.size(); ++e) {
      const Edge& edge = mesh.edges[e];
      const auto& own = mesh.faces[edge.own.face()];
      const auto x = static_cast<std::size_t>(edge.own.side());
      REQUIRE(own[(x + 1) % 3] == edge.start);
      REQUIRE(own[(x + 2) % 3] == edge.end);
      if (!edge.is_border()) REQUIRE(edge.start < edge.end);
      for (const int level : {1, 2, 5}) {
        const std::int64_t n = slot_side(level);
        for (std::int64_t row = 0; row < n; ++row) {
          for (std::int64_t column = 0; row + column < n; ++column) {
            const FaceIndex point = face_index(mesh, {e, level, row, column});
            const std::int64_t weights[3] = {2 * n - point.i - point.j, point.i, point.j};
            if (point.face != edge.own.face() || weights[(x + 1) % 3] != 2 * row + 1 ||
                weights[(x + 2) % 3] != 2 * column + 1)
              FAIL("edge " << e << " row " << row << " column " << column);
            if (edge.is_border() || row + column == n - 1) continue;
            // The point with both coordinates mirrored has the same weights beyond the edge.
            const FaceIndex beyond = face_index(mesh, {e, level, n - 1 - row, n - 1 - column});
            const auto y = static_cast<std::size_t>(edge.other.side());
            const std::int64_t there[3] = {2 * n - beyond.i - beyond.j, beyond.i, beyond.j};
            if (beyond.face != edge.other.face() || there[(y + 1) % 3] != 2 * row + 1 ||
                there[(y + 2) % 3] != 2 * column + 1)
              FAIL("beyond edge " << e << " row " << row << " column " << column);
          }
        }
      }
    }
  }
}

TEST_CASE("EdgeIndex_PointsOnAnEdge_AgreeFromBothFacesThroughLevelTwelve") {
  for (const auto& [name, indexed] : test::all_meshes()) {
    INFO(name);
    const test::NaiveTopology topology(indexed);
    const Topology mesh = topology.view();
    std::size_t compared = 0, inner_edges = 0;
    for (const Edge& edge : mesh.edges) {
      if (edge.is_border()) continue;
      ++inner_edges;
      for (const int level : {1, 2, 3, 7, 12}) {
        const std::int64_t size = std::int64_t{1} << level;
        for (std::int64_t from_start = 1; from_start < size; ++from_start, ++compared) {
          const auto on_side = [&](FaceSide side, std::int64_t second_weight) {
            std::int64_t weights[3] = {};
            weights[(side.side() + 1) % 3] = size - second_weight;
            weights[(side.side() + 2) % 3] = second_weight;
            return FaceIndex{side.face(), level, weights[1], weights[2]};
          };
          const EdgeIndex own = edge_index(mesh, on_side(edge.own, from_start));
          const EdgeIndex other = edge_index(mesh, on_side(edge.other, size - from_start));
          if (!(own == other) || own.row + own.column != slot_side(own.level) - 1)
            FAIL("edge " << edge.start << "-" << edge.end << " level " << level << " point "
                         << from_start);
        }
      }
    }
    CHECK(compared == (1 + 3 + 7 + 127 + 4095) * inner_edges);
  }
}

TEST_CASE("EdgeIndex_RandomPointsToLevelTwenty_RoundTrip") {
  std::mt19937_64 random(20250101);
  for (const auto& [name, indexed] : test::all_meshes()) {
    INFO(name);
    const test::NaiveTopology topology(indexed);
    const Topology mesh = topology.view();
    int good_rounds = 0;
    for (int round = 0; round < 5000; ++round) {
      const FaceIndex point = random_point(mesh, random);
      const EdgeIndex at = edge_index(mesh, point);
      const FaceIndex back = face_index(mesh, at);
      const std::int64_t n = slot_side(at.level);
      const SlotShape shape = shape_of(mesh.edges[at.edge]);
      const std::int64_t position = slot_position(at.level, shape, at.row, at.column);
      const bool good =
          is_inside(back) && back.level == at.level && at.level <= point.level &&
          identity(mesh, back) == identity(mesh, point) && edge_index(mesh, back) == at &&
          // the level at which one looks does not matter, and births are the coarsest level
          edge_index(mesh, at_level(point, kMaxLevel)) == at &&
          at_level(at_level(point, kMaxLevel), point.level) == point &&
          ((back.i | back.j) & 1) == 1 && at.row >= 0 && at.row < n && at.column >= 0 &&
          at.column < n && position >= 0 &&
          static_cast<std::uint64_t>(position) < slot_records(at.level, shape);
      if (!good)
        FAIL("face " << point.face << " level " << point.level << " (" << point.i << ", " << point.j
                     << ")");
      ++good_rounds;
    }
    CHECK(good_rounds == 5000);
  }
}

TEST_CASE("SlotPosition_EveryShape_IsABijectionInRowOrder") {
  for (int level = 1; level <= 8; ++level) {
    const std::int64_t n = slot_side(level);
    REQUIRE(n == std::int64_t{1} << (level - 1));
    for (const SlotShape shape : {SlotShape::kWhole, SlotShape::kHalf, SlotShape::kAbsent}) {
      std::int64_t next = 0;
      for (std::int64_t row = 0; row < n; ++row)
        for (std::int64_t column = 0; column < row_records(shape, n, row); ++column)
          REQUIRE(slot_position(level, shape, row, column) == next++);
      REQUIRE(static_cast<std::uint64_t>(next) == slot_records(level, shape));
    }
  }
  const std::int64_t n = slot_side(kMaxLevel);
  REQUIRE(slot_position(kMaxLevel, SlotShape::kWhole, n - 1, n - 1) == n * n - 1);
  REQUIRE(slot_position(kMaxLevel, SlotShape::kHalf, n - 1, 0) == n * (n + 1) / 2 - 1);
  REQUIRE(slot_records(kMaxLevel) == std::uint64_t{1} << 38);
}

TEST_CASE("CornerPoint_AllLevels_IsTheCornerAndNothingElseIs") {
  for (int level = 0; level <= kMaxLevel; ++level) {
    for (int corner = 0; corner < 3; ++corner) {
      const FaceIndex point = corner_point(5, level, corner);
      REQUIRE(is_corner(level, point.i, point.j));
      REQUIRE(corner_of(point.i, point.j) == corner);
      REQUIRE(point.face == 5);
      REQUIRE(at_level(corner_point(5, 0, corner), level) == point);
    }
  }
  int corners = 0;
  for (std::int64_t i = 0; i <= 16; ++i)
    for (std::int64_t j = 0; i + j <= 16; ++j) corners += is_corner(4, i, j);
  REQUIRE(corners == 3);
}

TEST_CASE("Unfold_PointBeyondASide_IsTheSamePointOfThePlane") {
  // Two faces unfolded into a plane, with integer coordinates: the corner beyond is placed by
  // the parallelogram, and a point is the weighted sum of its face's corners, negative or not.
  struct Plane {
    std::int64_t x, y;
    bool operator==(const Plane&) const = default;
  };
  using Corners = std::array<Plane, 3>;
  const auto place = [](const Corners& corners, const FaceIndex& point) {
    const std::int64_t weights[3] = {(std::int64_t{1} << point.level) - point.i - point.j, point.i,
                                     point.j};
    Plane sum{0, 0};
    for (std::size_t k = 0; k < 3; ++k) {
      sum.x += weights[k] * corners[k].x;
      sum.y += weights[k] * corners[k].y;
    }
    return sum;
  };
  std::mt19937_64 random(7);
  for (const auto& [name, indexed] : test::all_meshes()) {
    INFO(name);
    const test::NaiveTopology topology(indexed);
    const Topology mesh = topology.view();
    for (FaceId face = 0; face < mesh.faces.size(); ++face) {
      for (std::size_t x = 0; x < 3; ++x) {
        const FaceSide beyond = mesh.across(FaceSide(face, static_cast<int>(x)));
        if (!beyond.exists()) continue;
        const Corners here{Plane{11, -3}, Plane{140, 17}, Plane{29, 101}};
        const auto& names = mesh.faces[face];
        const auto& names_beyond = mesh.faces[beyond.face()];
        const auto y = static_cast<std::size_t>(beyond.side());
        REQUIRE(names_beyond[(y + 1) % 3] == names[(x + 2) % 3]);
        REQUIRE(names_beyond[(y + 2) % 3] == names[(x + 1) % 3]);
        Corners there;
        const Plane p = here[(x + 1) % 3], q = here[(x + 2) % 3], r = here[x];
        there[(y + 1) % 3] = q;
        there[(y + 2) % 3] = p;
        there[y] = {p.x + q.x - r.x, p.y + q.y - r.y};
        for (int round = 0; round < 20; ++round) {
          const int level = 1 + static_cast<int>(random() % kMaxLevel);
          const std::int64_t size = std::int64_t{1} << level;
          std::int64_t weights[3];
          weights[x] = -static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(size)) - 1;
          // Inside the face beyond: the two weights of the edge are at most `size` each.
          const std::int64_t least = -weights[x];
          weights[(x + 1) % 3] =
              least +
              static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(size - least + 1));
          weights[(x + 2) % 3] = size - weights[x] - weights[(x + 1) % 3];
          const FaceIndex point{face, level, weights[1], weights[2]};
          REQUIRE(side_beyond(point) == static_cast<int>(x));
          const FaceIndex unfolded = unfold(mesh, point, static_cast<int>(x));
          REQUIRE(unfolded.face == beyond.face());
          REQUIRE(is_inside(unfolded));
          REQUIRE(side_beyond(unfolded) == -1);
          REQUIRE(place(there, unfolded) == place(here, point));
          REQUIRE(unfold(mesh, unfolded, beyond.side()) == point);
        }
      }
    }
  }
}

TEST_CASE("Topology_NextCorner_TurnsCounterclockwiseRoundEveryVertex") {
  for (const auto& [name, indexed] : test::all_meshes()) {
    INFO(name);
    const test::NaiveTopology topology(indexed);
    const Topology mesh = topology.view();
    const naive::Mesh oracle = test::to_naive(indexed);
    const naive::Rings rings(oracle);
    for (VertexId v = 0; v < indexed.positions.size(); ++v) {
      const naive::Ring ring = rings.find(v);
      std::vector<naive::Index> found;
      FaceSide corner = mesh.vertex_corners[v], last;
      do {
        const auto& face = mesh.faces[corner.face()];
        const auto at = static_cast<std::size_t>(corner.side());
        REQUIRE(face[at] == v);
        found.push_back(face[(at + 1) % 3]);
        last = corner;
        corner = mesh.next_corner(corner);
      } while (corner.exists() && !(corner == mesh.vertex_corners[v]) && found.size() < 99);
      REQUIRE(corner.exists() == ring.closed);
      if (!ring.closed)
        found.push_back(mesh.faces[last.face()][static_cast<std::size_t>((last.side() + 2) % 3)]);
      REQUIRE(found == ring.neighbours);
    }
  }
}
