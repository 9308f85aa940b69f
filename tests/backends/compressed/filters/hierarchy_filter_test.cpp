// The filter hierarchy: its residuals against predictions that are computed vertex by vertex, and
// that any bytes come back.
#include <xmmintrin.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cfenv>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>
#include <string>

#include "backends/compressed/filters/hierarchy_oracle.h"
#include "backends/compressed/filters/predicted_levels.h"
#include "base/number_lattice.h"
#include "compressed/filters/built_in_filters.h"
#include "plait/error.h"
#include "plait/layout.h"
#include "rows/every_target.h"
#include "support/random_depths.h"
#include "support/sanitized.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

std::unique_ptr<Filter> hierarchy(const FilterLevel& level, const char* options = "") {
  return make_hierarchy_filter(options, level);
}

constexpr std::uint64_t kAllInOneBlock = 1 << 24;

void fill_at_random(PredictedLevels<float>& levels, std::mt19937& random) {
  std::uniform_real_distribution<float> next(-2, 2);
  levels.fill([&] { return next(random); });
}

/// Compares the residuals of a level in one block with `expected(number found, its index,
/// component)`. Returns how many blocks the filter needed.
template <class Expected>
std::size_t check_residuals(const PredictedLevels<float>& levels, int level, const char* options,
                            const Expected& expected) {
  const FilteredBlock made =
      encode_and_decode(*hierarchy(levels.filter_level(level), options), levels, level, 0);
  CHECK(std::ranges::equal(made.back, levels.block(level, 0)));
  const auto* const residuals = reinterpret_cast<const std::uint32_t*>(made.filtered.data());
  std::size_t at = 0, wrong = 0;
  levels.for_each_record(level, [&](const EdgeIndex& index) {
    for (std::size_t k = 0; k < 3; ++k, ++at) {
      const float found = levels.records[static_cast<std::size_t>(level - 1)][at / 3][k];
      wrong += residuals[at] != expected(found, index, k);
    }
  });
  CHECK(at * sizeof(float) == made.filtered.size());
  CHECK(wrong == 0);
  return made.needed_count;
}

}  // namespace

TEST_CASE("Hierarchy_LevelsInOneBlock_HasTheResidualsOfTheOracle") {
  for (const NamedMesh& named : all_meshes())
    for (const char* rule : {"midpoint", "butterfly", "loop"}) {
      PredictedLevels<float> levels(BaseMesh::build(named.mesh), 4, kAllInOneBlock);
      std::mt19937 random(7);
      fill_at_random(levels, random);
      const Oracle<float> oracle(levels, rule);
      for (int level = 1; level <= 4; ++level) {
        CAPTURE(named.name, rule, level);
        CHECK(check_residuals(levels, level, rule,
                              [&](float found, const EdgeIndex& index, std::size_t k) {
                                return expected_residual(found, oracle.predict(index, k));
                              }) == static_cast<std::size_t>(level - 1));
      }
    }
}

TEST_CASE("Hierarchy_AlongNormals_HasTheResidualsOfTheOracle") {
  const char* const rules[] = {"butterfly", "loop", "midpoint"};
  for (const NamedMesh& named : all_meshes())
    for (int note = 3; note < 6; ++note)
      for (int level = unless_sanitized(1, 3); level <= unless_sanitized(4, 3); ++level) {
        CAPTURE(named.name, note, level);
        PredictedLevels<float> levels(BaseMesh::build(named.mesh), level, kAllInOneBlock);
        std::mt19937 random(7);
        fill_at_random(levels, random);
        const auto filter = hierarchy(levels.filter_level(level), "along");
        FilteredBlock made = encode_and_decode(*filter, levels, level, 0);
        CHECK(std::ranges::equal(made.back, levels.block(level, 0)));
        // The vertices that have moved along their normals, from where the note's rule has them.
        const Oracle<float> oracle(levels, rules[note - 3]);
        auto* const residuals = reinterpret_cast<std::uint32_t*>(made.filtered.data());
        for (EdgeId edge = 0; edge < levels.mesh.edge_count(); ++edge) {
          const Slot slot = levels.geometry(level).slot(edge);
          for (std::size_t i = slot.offset / 4; i < (slot.offset + slot.bytes) / 4; ++i)
            residuals[i] = i % 3 == oracle.axis_of(level, edge)
                               ? static_cast<std::uint32_t>(random()) >> 12
                               : 0;
        }
        std::byte noted{static_cast<unsigned char>(note)};
        const FilterBlock with{0, made.context, made.scratch, &noted};
        filter->decode(with, made.filtered, made.back);
        std::vector<std::byte> again(made.back.size());
        filter->encode(with, made.back, again);
        if (level >= 3) CHECK((again == made.filtered));
        if (level >= 3) CHECK(std::to_integer<int>(noted) == note);
        const auto* const numbers = reinterpret_cast<const float*>(made.back.data());
        std::size_t at = 0, wrong = 0;
        levels.for_each_record(level, [&](const EdgeIndex& index) {
          const auto predicted =
              oracle.predict_along(index, {numbers[at], numbers[at + 1], numbers[at + 2]});
          for (std::size_t k = 0; k < 3; ++k, ++at)
            wrong += residuals[at] != expected_residual(numbers[at], predicted[k]);
        });
        CHECK(at * sizeof(float) == made.filtered.size());
        CHECK(wrong == 0);
      }
}

TEST_CASE("Hierarchy_OfFacesWithDepths_HasTheResidualsOfTheOracle") {
  std::mt19937 random(21);
  std::size_t turned = 0, patterns = 0;
  for (const NamedMesh& named : all_meshes())
    for (int turn = 0; turn < unless_sanitized(6, 1); ++turn) {
      const BaseMesh base = BaseMesh::build(named.mesh);
      if (base.face_count() > 200) continue;
      const BaseMesh deep = base.with_depths(random_depths(base.face_count(), random, 4));
      if (deep.depths()->deepest() == 0) continue;
      PredictedLevels<float> levels(deep, deep.depths()->deepest(), kAllInOneBlock);
      fill_at_random(levels, random);
      ++patterns;
      for (const char* rule : {"midpoint", "butterfly", "loop"}) {
        const Oracle<float> oracle(levels, rule);
        for (int level = 1; level <= deep.depths()->deepest(); ++level) {
          CAPTURE(named.name, turn, rule, level);
          check_residuals(levels, level, rule,
                          [&](float found, const EdgeIndex& index, std::size_t k) {
                            turned += levels.is_turned(level, index.edge) ? 1u : 0u;
                            return expected_residual(found, oracle.predict(index, k));
                          });
        }
      }
    }
  CHECK(turned > 0);
  CHECK(patterns > 20);
}

TEST_CASE("Hierarchy_AnyBitsOfFacesWithDepths_ComeBackInBlocksOfAnySize") {
  std::mt19937 random(22);
  for (const NamedMesh& named : all_meshes())
    for (const std::uint64_t block_bytes : {64u, 1024u, 16384u})
      for (const char* options : {"", "along", "butterfly:step=0.01"}) {
        CAPTURE(named.name, block_bytes, options);
        const BaseMesh base = BaseMesh::build(named.mesh);
        const BaseMesh deep = base.with_depths(random_depths(base.face_count(), random, 4));
        const int deepest = deep.depths()->deepest();
        PredictedLevels<float> levels(deep, deepest, block_bytes);
        levels.fill([&] { return std::bit_cast<float>(static_cast<std::uint32_t>(random())); });
        std::size_t wrong = 0;
        for (int level = 1; level <= deepest; ++level) {
          const auto filter = hierarchy(levels.filter_level(level), options);
          for (std::uint64_t block = 0; block < levels.geometry(level).block_count(); ++block) {
            const FilteredBlock made = encode_and_decode(*filter, levels, level, block);
            wrong += !std::ranges::equal(made.back, levels.block(level, block));
            // The block that has the first slot's edge comes with each coarser level.
            EdgeId first = levels.geometry(level).first_edge(block);
            while (!levels.geometry(level).has_slot(first)) ++first;
            for (int coarser = 1; coarser < level; ++coarser)
              wrong += std::ranges::none_of(
                  std::span(made.needed).first(made.needed_count), [&](const ContextBlock& each) {
                    return each.level == coarser &&
                           each.block == levels.geometry(coarser).block_of(first);
                  });
          }
        }
        CHECK(wrong == 0);
      }
}

TEST_CASE("Hierarchy_AnyBits_ComeBackInBlocksOfAnySize") {
  for (const NamedMesh& named : all_meshes())
    for (const std::uint64_t block_bytes : {4096u, 16384u}) {
      PredictedLevels<float> floats(BaseMesh::build(named.mesh), 5, block_bytes);
      PredictedLevels<double> doubles(BaseMesh::build(named.mesh), 4, block_bytes);
      std::mt19937_64 random(3);
      floats.fill([&] { return std::bit_cast<float>(static_cast<std::uint32_t>(random())); });
      doubles.fill([&] { return std::bit_cast<double>(random()); });
      std::size_t wrong = 0;
      const auto check = [&](const auto& levels, int finest) {
        for (int level = 1; level <= finest; ++level)
          for (const char* options : {"", "along"}) {
            const auto filter = hierarchy(levels.filter_level(level), options);
            for (std::uint64_t block = 0; block < levels.geometry(level).block_count(); ++block) {
              const FilteredBlock made = encode_and_decode(*filter, levels, level, block);
              if (!std::ranges::equal(made.back, levels.block(level, block))) ++wrong;
            }
          }
      };
      CAPTURE(named.name, block_bytes);
      check(floats, 5);
      check(doubles, 4);
      CHECK(wrong == 0);
    }
}

TEST_CASE("Hierarchy_WithAStep_HasResidualsInStepsOfTheOraclesPredictions") {
  constexpr double kStep = 3e-3;
  PredictedLevels<float> levels(BaseMesh::build(random_sheet(4, 60)), 4, kAllInOneBlock);
  std::mt19937 random(9);
  levels.fill([&] {
    const std::int32_t index = static_cast<std::int32_t>(random()) / 2'000'000;
    return static_cast<float>(index * kStep);
  });
  const Oracle<float> oracle(levels, "butterfly");
  for (int level = 1; level <= 4; ++level) {
    check_residuals(levels, level, "butterfly:step=3e-3",
                    [&](float found, const EdgeIndex& index, std::size_t k) {
                      const auto steps = static_cast<std::int64_t>(
                          std::nearbyint(double{found} / kStep) -
                          std::nearbyint(double{oracle.predict(index, k)} * (1 / kStep)));
                      return static_cast<std::uint32_t>(steps >= 0 ? 2 * steps : -2 * steps - 1);
                    });
  }
}

TEST_CASE("Hierarchy_WithAStepAndAnyBits_GivesThemBack") {
  PredictedLevels<float> floats(BaseMesh::build(random_sheet(3, 40)), 4, 4096);
  PredictedLevels<double> doubles(BaseMesh::build(icosahedron()), 4, 4096);
  std::mt19937_64 random(8);
  const auto word = [&](auto number) {
    using Number = decltype(number);
    using Word = typename NumberLattice<Number>::Word;
    // Any bits, small bits that are places of indices, and numbers of the lattice.
    const auto choice = random() % 3;
    if (choice == 0) return std::bit_cast<Number>(static_cast<Word>(random()));
    const auto small = static_cast<std::int64_t>(random() % 9'000'001) - 4'500'000;
    if (choice == 1) return std::bit_cast<Number>(static_cast<Word>(small));
    return static_cast<Number>(static_cast<double>(small) * 0.01);
  };
  floats.fill([&] { return word(float{}); });
  doubles.fill([&] { return word(double{}); });
  std::size_t wrong = 0;
  const auto check = [&](const auto& levels) {
    for (int level = 1; level <= 4; ++level)
      for (const char* options :
           {"step=0.01", "midpoint:step=1e-30", "butterfly:step=4", "loop:step=0.02"}) {
        const auto filter = hierarchy(levels.filter_level(level), options);
        for (std::uint64_t block = 0; block < levels.geometry(level).block_count(); ++block) {
          const FilteredBlock made = encode_and_decode(*filter, levels, level, block);
          if (!std::ranges::equal(made.back, levels.block(level, block))) ++wrong;
        }
      }
  };
  check(floats);
  check(doubles);
  CHECK(wrong == 0);
}

TEST_CASE("Hierarchy_ContextOfABlock_IsBoundedAndHasTheBlockOfTheSameEdges") {
  PredictedLevels<float> levels(BaseMesh::build(torus_grid(60, 40)), 5, 16384);
  for (int level = 1; level <= 5; ++level) {
    const auto filter = hierarchy(levels.filter_level(level));
    const LevelGeometry& own = levels.geometry(level);
    for (std::uint64_t block = 0; block < own.block_count(); ++block) {
      std::array<ContextBlock, kMostContextBlocks> needed;
      const std::size_t count = filter->context(block, needed);
      REQUIRE(count <= kMostContextBlocks);
      std::set<std::pair<int, std::uint64_t>> blocks;
      for (std::size_t i = 0; i < count; ++i) blocks.emplace(needed[i].level, needed[i].block);
      CHECK(blocks.size() == count);
      for (int coarser = 1; coarser < level; ++coarser)
        CHECK(blocks.contains({coarser, levels.geometry(coarser).block_of(own.first_edge(block))}));
      if (count > 0) CHECK(std::prev(blocks.end())->first == level - 1);
    }
  }
}

namespace {

/// How many of 1,000 slots of coarser levels are in no block that a block's context has, of those
/// in the faces at the block's edges, and in the next faces.
struct LeftOut {
  double own_faces = 0, next_faces = 0;
};

/// The slots of coarser levels that a block's context has.
class Known {
 public:
  Known(const PredictedLevels<float>& levels, const Filter& filter, int level, std::uint64_t block)
      : levels_(levels), level_(level) {
    std::array<ContextBlock, kMostContextBlocks> needed;
    const std::size_t count = filter.context(block, needed);
    for (std::size_t i = 0; i < count; ++i) blocks_.emplace(needed[i].level, needed[i].block);
  }
  bool has(int coarser, EdgeId edge) const {
    return blocks_.contains({coarser, levels_.geometry(coarser).block_of(edge)});
  }
  /// Calls visit(coarser level, edge, distance) for the slots in the faces at the edge, distance 0,
  /// and in the next faces, distance 1.
  template <class Visit>
  void visit_around(EdgeId edge, Visit visit) const {
    const Topology mesh = levels_.surroundings.mesh;
    const auto visit_face = [&](FaceId face, int distance) {
      for (const EdgeId each : mesh.face_edges[face])
        for (int coarser = 1; coarser < level_; ++coarser) visit(coarser, each, distance);
    };
    for (const FaceSide side : {mesh.edges[edge].own, mesh.edges[edge].other}) {
      if (!side.exists()) continue;
      visit_face(side.face(), 0);
      for (int turn = 1; turn < 3; ++turn) {
        const FaceSide next = mesh.across(FaceSide(side.face(), (side.side() + turn) % 3));
        if (next.exists()) visit_face(next.face(), 1);
      }
    }
  }
  bool are_all_around(EdgeId edge) const {
    bool all = true;
    visit_around(edge, [&](int coarser, EdgeId each, int) { all = all && has(coarser, each); });
    return all;
  }

 private:
  const PredictedLevels<float>& levels_;
  int level_;
  std::set<std::pair<int, std::uint64_t>> blocks_;
};

LeftOut left_out(const PredictedLevels<float>& levels, int level) {
  const auto filter = hierarchy(levels.filter_level(level));
  const LevelGeometry& own = levels.geometry(level);
  double slots[2] = {}, outside[2] = {};
  for (std::uint64_t block = 0; block < own.block_count(); ++block) {
    const Known known(levels, *filter, level, block);
    for (EdgeId edge = own.first_edge(block); edge < own.edge_after(block); ++edge)
      known.visit_around(edge, [&](int coarser, EdgeId each, int distance) {
        ++slots[distance];
        if (!known.has(coarser, each)) ++outside[distance];
      });
  }
  return {1000 * outside[0] / slots[0], 1000 * outside[1] / slots[1]};
}

}  // namespace

TEST_CASE("Hierarchy_LevelsInManyBlocks_HasTheResidualsOfOneBlockWhereAllIsKnown") {
  const std::string rule = GENERATE("midpoint", "butterfly", "loop");
  const BaseMesh mesh = lay_out(BaseMesh::build(random_sheet(4, 600)), LayoutKind::kAutomatic).mesh;
  PredictedLevels<float> whole(mesh, 4, kAllInOneBlock), divided(mesh, 4, 8192);
  for (PredictedLevels<float>* const levels : {&whole, &divided}) {
    std::mt19937 random(5);
    fill_at_random(*levels, random);
  }
  for (int level = 2; level <= 4; ++level) {
    CAPTURE(level);
    const auto filter = hierarchy(divided.filter_level(level), rule.c_str());
    const FilteredBlock expected =
        encode_and_decode(*hierarchy(whole.filter_level(level), rule.c_str()), whole, level, 0);
    const LevelGeometry& own = divided.geometry(level);
    std::size_t known = 0, wrong = 0;
    for (std::uint64_t block = 0; block < own.block_count(); ++block) {
      const FilteredBlock made = encode_and_decode(*filter, divided, level, block);
      const Known known_slots(divided, *filter, level, block);
      for (EdgeId edge = own.first_edge(block); edge < own.edge_after(block); ++edge) {
        if (!known_slots.are_all_around(edge)) continue;
        ++known;
        const Slot slot = own.slot(edge), other = whole.geometry(level).slot(edge);
        wrong += std::memcmp(&made.filtered[slot.offset - own.block_offset(block)],
                             &expected.filtered[other.offset], slot.bytes) != 0;
      }
    }
    CHECK(own.block_count() > 1);
    CHECK(known > mesh.edge_count() / 2);
    CHECK(wrong == 0);
  }
}

TEST_CASE("Hierarchy_FacesOfABlock_AreNearlyAllInItsContext") {
  // As docs/filters/hierarchy.md says, of a mesh of 8,000 vertices in the order of a store.
  PredictedLevels<float> levels(
      lay_out(BaseMesh::build(torus_grid(100, 80)), LayoutKind::kAutomatic).mesh, 5, 1 << 18);
  for (const int level : {3, 4, 5}) {
    const LeftOut found = left_out(levels, level);
    CAPTURE(level, found.own_faces, found.next_faces);
    CHECK(found.own_faces <= 2);
    CHECK(found.next_faces <= 10);
  }
}

TEST_CASE("Hierarchy_WithoutARule_TakesTheOneThatPredictsABlockBest") {
  PredictedLevels<float> levels(BaseMesh::build(torus_grid(6, 5)), 4, 1 << 14);
  std::mt19937 random(17);
  std::uniform_real_distribution<float> next(-2, 2);
  const auto best = hierarchy(levels.filter_level(4));
  CHECK(best->keeps_note());
  std::size_t expected_note = 0;
  for (const char* rule : {"butterfly", "loop", "midpoint"}) {
    const auto fixed = hierarchy(levels.filter_level(4), rule);
    CHECK_FALSE(fixed->keeps_note());
    for (std::uint64_t block = 0; block < levels.geometry(4).block_count(); ++block) {
      levels.fill([&] { return next(random); });
      // A block without residuals, but for one vertex that no rule predicts.
      FilteredBlock made = encode_and_decode(*fixed, levels, 4, block);
      std::ranges::fill(made.filtered, std::byte{0});
      made.filtered[5] = std::byte{77};
      fixed->decode({block, made.context, made.scratch}, made.filtered, made.back);
      std::vector<std::byte> filtered(made.back.size()), back(made.back.size());
      std::byte note{99};
      const FilterBlock with{block, made.context, made.scratch, &note};
      best->encode(with, made.back, filtered);
      CHECK(std::to_integer<std::size_t>(note) == expected_note);
      CHECK((filtered == made.filtered));
      best->decode(with, filtered, back);
      CHECK((back == made.back));
      for (const int hostile : {3, 4, 128, 255}) {
        note = static_cast<std::byte>(hostile);
        try {
          best->decode(with, filtered, back);
          CHECK(false);
        } catch (const Error& error) {
          CHECK(error.code() == ErrorCode::kCorruption);
        }
      }
    }
    ++expected_note;
  }
}

TEST_CASE("Hierarchy_OnEveryInstructionSet_MakesTheSameBytes") {
  const auto check = [](auto number, const char* rule) {
    using Number = decltype(number);
    for (const NamedMesh& named : all_meshes()) {
      constexpr int kFinest = unless_sanitized(5, 3);
      PredictedLevels<Number> levels(BaseMesh::build(named.mesh), kFinest, kAllInOneBlock);
      std::mt19937 random(5);
      // Among them numbers that are none, and denormal ones.
      levels.fill([&] {
        const auto choice = random() % 64;
        if (choice == 0) return std::numeric_limits<Number>::infinity();
        if (choice == 1) return std::numeric_limits<Number>::denorm_min();
        return static_cast<Number>(random()) / Number(7e8);
      });
      for (int level = 1; level <= kFinest; ++level) {
        const auto filter = hierarchy(levels.filter_level(level), rule);
        std::vector<std::byte> expected;
        fused_rows::on_every_target([&](const char* target) {
          CAPTURE(named.name, level, target, rule, sizeof(Number));
          const FilteredBlock made = encode_and_decode(*filter, levels, level, 0);
          if (expected.empty()) expected = made.filtered;
          CHECK(std::ranges::equal(made.back, levels.block(level, 0)));
          CHECK((made.filtered == expected));
        });
      }
    }
  };
  for (const char* rule : {"butterfly", "loop", "midpoint", "along"}) {
    check(float{}, rule);
    check(double{}, rule);
  }
}

TEST_CASE("Hierarchy_OtherArithmeticOfTheProgram_MakesTheSameBytes") {
  PredictedLevels<float> levels(BaseMesh::build(icosahedron()), 4, kAllInOneBlock);
  std::mt19937 random(5);
  std::uniform_real_distribution<float> next(-1e-38f, 1e-38f);  // denormal numbers among them
  levels.fill([&] { return next(random); });
  const auto filter = hierarchy(levels.filter_level(4));
  const std::vector<std::byte> expected = encode_and_decode(*filter, levels, 4, 0).filtered;
  const unsigned former = _mm_getcsr();
  for (const unsigned bits : {0x8040u, 0x2000u, 0x4000u, 0x6000u}) {  // flush to zero; directions
    _mm_setcsr(former | bits);
    const std::vector<std::byte> made = encode_and_decode(*filter, levels, 4, 0).filtered;
    const unsigned after = _mm_getcsr();
    _mm_setcsr(former);
    CHECK(made == expected);
    CHECK((after & 0xe040u) == ((former | bits) & 0xe040u));
  }
}

TEST_CASE("Hierarchy_RecordsOrOptionsThatItDoesNotTake_AreRefused") {
  const auto refusal = [](const AttributeSchema& schema, const char* options) {
    try {
      hierarchy({.schema = schema}, options);
    } catch (const Error& error) {
      return error.code();
    }
    return ErrorCode::kCancelled;
  };
  CHECK(refusal({"id", ComponentType::kInt32, 3}, "") == ErrorCode::kNotSupported);
  CHECK(refusal({"colours", ComponentType::kUint8, 3}, "") == ErrorCode::kNotSupported);
  CHECK(refusal({"weights", ComponentType::kFloat32, 5}, "") == ErrorCode::kNotSupported);
  CHECK(refusal({"weights", ComponentType::kFloat32, 2}, "along") == ErrorCode::kNotSupported);
  CHECK(refusal({"position", ComponentType::kFloat32, 3}, "cubic") == ErrorCode::kInvalidArgument);
  for (const char* step : {"step=", "step=0", "step=-1", "step=nan", "step=1e-60", "step=1e60",
                           "step=1x", "midpoint:step=", "cubic:step=1", ":step=1"})
    CHECK(refusal({"position", ComponentType::kFloat32, 3}, step) == ErrorCode::kInvalidArgument);
  CHECK(refusal({"position", ComponentType::kFloat32, 3}, "midpoint:step=0.1") ==
        ErrorCode::kCancelled);
  for (std::uint32_t components = 1; components <= 4; ++components)
    for (const ComponentType type : {ComponentType::kFloat32, ComponentType::kFloat64})
      CHECK(refusal({"taken", type, components}, "loop") == ErrorCode::kCancelled);
}

}  // namespace plait::test
