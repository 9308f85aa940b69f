// The filter normals: its predictions against tangent masks in double, and that any bytes come
// back.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "backends/compressed/filters/predicted_levels.h"
#include "compressed/filters/built_in_filters.h"
#include "plait/error.h"
#include "plait/extend/vector3.h"
#include "rows/every_target.h"
#include "support/random_depths.h"
#include "support/sanitized.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

using Normals = std::vector<std::array<float, 3>>;

/// Positions, and the level of an attribute of normals beside them.
template <class Real>
struct Surface {
  Surface(const IndexedMesh& mesh, int finest, std::uint64_t block_bytes)
      : Surface(BaseMesh::build(mesh), finest, block_bytes) {}
  Surface(const BaseMesh& mesh, int finest, std::uint64_t block_bytes)
      : positions(mesh, finest, block_bytes), bytes(block_bytes) {
    positions.surroundings.attributes[0].schema.name = "position";
  }
  LevelGeometry geometry(int level) const {
    return positions.mesh.geometry(BaseRelativeLevel(level), 12, bytes);
  }
  FilterLevel filter_level(const LevelGeometry& of, int level) const {
    return {.schema = {.name = "normal"},
            .geometry = &of,
            .attribute = 1,
            .level = level,
            .surroundings = &positions.surroundings};
  }
  /// The filter's context and working memory for a block.
  FilteredBlock prepare(const Filter& filter, std::uint64_t block) const {
    FilteredBlock made;
    made.needed_count = filter.context(block, made.needed);
    for (const ContextBlock& needed : std::span(made.needed).first(made.needed_count))
      made.context.push_back(positions.block(needed.level, needed.block));
    made.scratch.resize(filter.scratch_bytes());
    return made;
  }

  PredictedLevels<Real> positions;
  std::uint64_t bytes;
};

/// The normal of a vertex that is no base vertex, from its ring in the grid of `level`.
template <class Real>
Vector3<double> expected_normal(const PredictedLevels<Real>& levels, const EdgeIndex& index) {
  const Topology mesh = levels.surroundings.mesh;
  const FaceIndex at = face_index(mesh, index);
  constexpr std::int64_t kRing[6][2] = {{1, 0}, {0, 1}, {-1, 1}, {-1, 0}, {0, -1}, {1, -1}};
  const auto vertex = [&](const FaceIndex& point) {
    const auto& record = levels.vertex(point);
    return Vector3<double>{record[0], record[1], record[2]};
  };
  std::vector<Vector3<double>> ring;
  std::size_t after_gap = 0;
  for (std::size_t i = 0; i < 6; ++i) {
    const FaceIndex next =
        unfold_fully(mesh, {at.face, at.level, at.i + kRing[i][0], at.j + kRing[i][1]});
    if (next.face == kNoId)
      after_gap = ring.size();
    else
      ring.push_back(vertex(next));
  }
  std::rotate(ring.begin(), ring.begin() + static_cast<std::ptrdiff_t>(after_gap % ring.size()),
              ring.end());
  Vector3<double> first{}, second{};
  if (ring.size() == 6) {
    for (std::size_t i = 0; i < 6; ++i) {
      const double angle = std::numbers::pi / 3 * static_cast<double>(i);
      first = first + std::cos(angle) * ring[i];
      second = second + std::sin(angle) * ring[i];
    }
  } else {
    REQUIRE(ring.size() == 4);
    first = ring[0] - ring[3];
    second = 2.0 * (ring[1] + ring[2]) - (ring[0] + ring[3]) - 2.0 * vertex(at);
  }
  return normalized(cross(first, second));
}

template <class Real>
void check_predictions(const NamedMesh& named) {
  Surface<Real> surface(named.mesh, 3, 1 << 24);
  std::mt19937 random(7);
  std::uniform_real_distribution<Real> next(-2, 2);
  surface.positions.fill([&] { return next(random); });
  for (int level = 1; level <= 3; ++level) {
    CAPTURE(named.name, level, sizeof(Real));
    const LevelGeometry geometry = surface.geometry(level);
    const auto filter = make_normals_filter("", surface.filter_level(geometry, level));
    const FilteredBlock with = surface.prepare(*filter, 0);
    CHECK(with.needed_count == static_cast<std::size_t>(level));
    std::vector<std::byte> scratch = with.scratch;
    // Residuals of zero give the predictions themselves.
    Normals normals(geometry.total_bytes() / 12);
    const std::vector<std::byte> zeros(geometry.total_bytes());
    filter->decode({0, with.context, scratch}, zeros, std::as_writable_bytes(std::span(normals)));
    const std::int64_t n = slot_side(level);
    std::size_t at = 0, wrong = 0;
    for (EdgeId edge = 0; edge < surface.positions.mesh.edge_count(); ++edge) {
      const bool border = surface.positions.mesh.edges()[edge].is_border();
      for (std::int64_t row = 0; row < n; ++row)
        for (std::int64_t column = 0; column < (border ? n - row : n); ++column, ++at) {
          const Vector3<double> expected =
              expected_normal(surface.positions, {edge, level, row, column});
          const Vector3<double> found{normals[at][0], normals[at][1], normals[at][2]};
          const Vector3<double> d = found - expected;
          if (!(dot(d, d) < 1e-8)) ++wrong;
        }
    }
    CHECK(at == normals.size());
    // Random positions make a few triangles so flat that rounding turns them.
    CHECK(wrong <= normals.size() / 500);
  }
}

}  // namespace

TEST_CASE("Normals_OfAnyPositions_ArePredictedByTheTangentMasks") {
  for (const NamedMesh& named : all_meshes()) {
    check_predictions<float>(named);
    check_predictions<double>(named);
  }
}

TEST_CASE("Normals_OfFacesWithDepths_ArePredictedAndComeBack") {
  std::mt19937 random(9);
  std::uniform_real_distribution<float> next(-2, 2);
  std::size_t checked = 0, wrong_bits = 0, wrong = 0;
  for (const NamedMesh& named : all_meshes())
    for (const std::uint64_t block_bytes : {64u, 1u << 24}) {
      const BaseMesh base = BaseMesh::build(named.mesh);
      const BaseMesh deep = base.with_depths(random_depths(base.face_count(), random, 4));
      Surface<float> surface(deep, deep.depths()->deepest(), block_bytes);
      surface.positions.fill([&] { return next(random); });
      for (int level = 1; level <= deep.depths()->deepest(); ++level) {
        const LevelGeometry geometry = surface.geometry(level);
        const auto filter = make_normals_filter("", surface.filter_level(geometry, level));
        Normals normals(geometry.total_bytes() / 12);
        for (std::uint64_t block = 0; block < geometry.block_count(); ++block) {
          FilteredBlock made = surface.prepare(*filter, block);
          std::vector<std::byte> raw(geometry.block_bytes(block));
          for (std::byte& byte : raw) byte = static_cast<std::byte>(random());
          made.filtered.resize(raw.size());
          made.back.resize(raw.size());
          const FilterBlock with{block, made.context, made.scratch};
          filter->encode(with, raw, made.filtered);
          filter->decode(with, made.filtered, made.back);
          wrong_bits += !std::ranges::equal(raw, made.back);
          // Residuals of zero give the predictions themselves.
          std::ranges::fill(made.filtered, std::byte{0});
          filter->decode(with, made.filtered,
                         std::as_writable_bytes(std::span(normals))
                             .subspan(geometry.block_offset(block), raw.size()));
        }
        if (geometry.block_count() > 1) continue;
        std::size_t at = 0;
        surface.positions.for_each_record(level, [&](const EdgeIndex& index) {
          const auto& found = normals[at++];
          // The other records on the edge have neighbours in a face without this level.
          if (geometry.slot(index.edge).shape == SlotShape::kHalf &&
              index.row + index.column == slot_side(level) - 1)
            return;
          ++checked;
          const Vector3<double> expected = expected_normal(surface.positions, index);
          const Vector3<double> d = Vector3<double>{found[0], found[1], found[2]} - expected;
          wrong += !(dot(d, d) < 1e-8);
        });
      }
    }
  CHECK(wrong_bits == 0);
  CHECK(checked > 10000);
  CHECK(wrong <= checked / 500);
}

TEST_CASE("Normals_AnyBits_ComeBackInBlocksOfAnySize") {
  for (const NamedMesh& named : all_meshes())
    for (const bool precise : {false, true}) {
      CAPTURE(named.name, precise);
      const auto check = [&]<class Real>(Surface<Real> surface, Real) {
        std::mt19937_64 random(3);
        surface.positions.fill([&] { return static_cast<Real>(std::bit_cast<double>(random())); });
        std::size_t wrong = 0;
        for (int level = 1; level <= 4; ++level) {
          const LevelGeometry geometry = surface.geometry(level);
          const auto filter = make_normals_filter("", surface.filter_level(geometry, level));
          for (std::uint64_t block = 0; block < geometry.block_count(); ++block) {
            FilteredBlock made = surface.prepare(*filter, block);
            std::vector<std::uint32_t> raw(geometry.block_bytes(block) / 4);
            std::ranges::generate(raw, [&] { return static_cast<std::uint32_t>(random()); });
            made.filtered.resize(4 * raw.size());
            made.back.resize(4 * raw.size());
            const FilterBlock with{block, made.context, made.scratch};
            filter->encode(with, std::as_bytes(std::span(raw)), made.filtered);
            filter->decode(with, made.filtered, made.back);
            if (!std::ranges::equal(std::as_bytes(std::span(raw)), made.back)) ++wrong;
          }
        }
        CHECK(wrong == 0);
      };
      if (precise)
        check.template operator()<double>({named.mesh, 4, 4096}, 0.0);
      else
        check.template operator()<float>({named.mesh, 4, 4096}, 0.0f);
    }
}

TEST_CASE("Normals_OnEveryInstructionSet_AreTheSame") {
  const auto check = [](auto real) {
    using Real = decltype(real);
    for (const NamedMesh& named : all_meshes()) {
      constexpr int kFinest = unless_sanitized(5, 3);
      Surface<Real> surface(named.mesh, kFinest, 1 << 24);
      std::mt19937 random(11);
      // Some triangles are so small or so large that lengths are computed in double.
      surface.positions.fill([&] {
        const auto choice = random() % 32;
        const Real scale = choice == 0 ? Real(1e-25) : choice == 1 ? Real(1e25) : Real(1);
        return scale * static_cast<Real>(random()) / Real(3e9);
      });
      for (int level = 1; level <= kFinest; ++level) {
        const LevelGeometry geometry = surface.geometry(level);
        const auto filter = make_normals_filter("", surface.filter_level(geometry, level));
        FilteredBlock made = surface.prepare(*filter, 0);
        const std::vector<std::byte> zeros(geometry.total_bytes());
        std::vector<std::byte> expected, normals(zeros.size()), residuals(zeros.size());
        fused_rows::on_every_target([&](const char* target) {
          CAPTURE(named.name, level, target, sizeof(Real));
          const FilterBlock with{0, made.context, made.scratch};
          filter->decode(with, zeros, normals);
          if (expected.empty()) expected = normals;
          CHECK((normals == expected));
          filter->encode(with, normals, residuals);
          CHECK((residuals == zeros));
        });
      }
    }
  };
  check(float{});
  check(double{});
}

TEST_CASE("Normals_WithoutPositionsOrOfOtherRecords_AreRefused") {
  Surface<float> surface(icosahedron(), 2, 4096);
  const LevelGeometry geometry = surface.geometry(2), finer = surface.geometry(3);
  const auto refused = [](const char* options, const FilterLevel& level) {
    try {
      make_normals_filter(options, level);
    } catch (const Error& error) {
      return error.code() == ErrorCode::kNotSupported;
    }
    return false;
  };
  FilterLevel level = surface.filter_level(geometry, 2);
  CHECK_FALSE(refused("", level));
  CHECK_FALSE(refused("position", level));
  CHECK(refused("points", level));
  CHECK(refused("", surface.filter_level(finer, 3)));
  level.attribute = 0;
  CHECK(refused("", level));
  level = surface.filter_level(geometry, 2);
  level.schema.components = 4;
  CHECK(refused("", level));
  level.schema = {"normal", ComponentType::kFloat64, 3};
  CHECK(refused("", level));
}

}  // namespace plait::test
