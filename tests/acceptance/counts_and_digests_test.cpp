// The real meshes refined: how many vertices there are and how many bytes they take, and one
// content whatever holds it, walks it and orders it.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <filesystem>
#include <optional>
#include <set>
#include <utility>

#include "acceptance/models.h"
#include "acceptance/variants.h"
#include "plait/backends/registry.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/mesh_io.h"
#include "plait/verify.h"
#include "support/temporary_directory.h"

using namespace plait;
using namespace plait::test;

namespace {

/// Level files are padded to a page.
constexpr std::uint64_t kPageBytes = 4096;
constexpr std::uint64_t kRecordBytes = 12;

struct Counts {
  std::uint64_t vertices, edges, faces;
};

/// Refining cuts edges in two and faces in four; three new edges lie in each old face.
Counts refined(const Counts& coarse) {
  return {coarse.vertices + coarse.edges, 2 * coarse.edges + 3 * coarse.faces, 4 * coarse.faces};
}

Counts counts_of(const BaseMesh& mesh) {
  return {mesh.vertex_count(), mesh.edge_count(), mesh.face_count()};
}

void check_one_digest(Refiner& refiner, const std::vector<Variant>& variants,
                      const std::string& expected) {
  for (const Variant& variant : variants) {
    INFO(to_string(variant));
    CHECK(refiner.digest_of(variant) == expected);
  }
}

/// Every level file of every attribute of a committed store in `pread`: as many records as the
/// formulas say, each written once, and no byte beside them but the padding of a page.
void check_levels(Store& store, int levels) {
  const BaseMesh& base = store.base();
  Counts counts = counts_of(base);
  for (AttributeId id = 0; id < store.attributes().size(); ++id)
    CHECK(store.base_bytes(id).size() == counts.vertices * kRecordBytes);
  std::uint64_t stored_vertices = counts.vertices;
  for (int level = 1; level <= levels; ++level) {
    INFO("level " << level);
    const std::uint64_t born = counts.edges;
    counts = refined(counts);
    for (AttributeId id = 0; id < store.attributes().size(); ++id) {
      const LevelFile& file = store.level_file(id, level);
      if (base.border_edge_count() == 0)
        CHECK(file.geometry.total_bytes() ==
              (base.edge_count() << (2 * (level - 1))) * kRecordBytes);
      CHECK(file.geometry.total_bytes() == born * kRecordBytes);
      const std::uint64_t file_bytes = std::filesystem::file_size(file.path);
      CHECK(file_bytes >= file.geometry.total_bytes());
      CHECK(file_bytes < file.geometry.total_bytes() + kPageBytes);
    }
    stored_vertices += store.level_file(0, level).geometry.total_bytes() / kRecordBytes;
    CHECK(stored_vertices == counts.vertices);
    const LevelCounts library = counts_at_level(base, level);
    CHECK(library.vertices == counts.vertices);
    CHECK(library.edges == counts.edges);
    CHECK(library.faces == counts.faces);
  }
  const VerifyReport report = verify(store);
  CHECK(report.damaged_count == 0);
  CHECK(report.never_written == 0);
  CHECK(report.bytes ==
        store.attributes().size() * kRecordBytes * (counts.vertices - base.vertex_count()));
}

}  // namespace

TEST_CASE("CoveringVariants_OverSixMeshes_BringEachBackendToEveryValue") {
  const auto values_of = [](const Variant& variant) {
    return std::array<std::string, 6>{
        variant.backend + variant.codec,     std::string(to_string(variant.executor)),
        std::to_string(variant.threads),     std::to_string(static_cast<int>(variant.budget)),
        std::to_string(variant.block_bytes), std::string(to_string(variant.layout))};
  };
  constexpr std::size_t kBackend = 0, kLayout = 5;
  const auto pairs_of = [&](const std::vector<Variant>& variants, std::size_t a, std::size_t b) {
    std::set<std::array<std::string, 2>> pairs;
    for (const Variant& variant : variants)
      pairs.insert({values_of(variant)[a], values_of(variant)[b]});
    return pairs;
  };
  std::vector<Variant> covering;
  for (int turn = 0; turn < 6; ++turn)
    for (const Variant& variant : covering_variants(turn)) covering.push_back(variant);
  CHECK(covering.size() == 30);
  CHECK(all_variants().size() == 480);
  for (std::size_t a = 1; a <= kLayout; ++a)
    for (std::size_t b = 0; b < a; ++b)
      if (b == kBackend || a != kLayout)
        CHECK(pairs_of(covering, a, b) == pairs_of(all_variants(), a, b));
}

TEST_CASE("Digest_FullProductOnTheSmallestModel_IsOne") {
  if (!has_model("spot")) return;
  Refiner refiner(read_base_mesh(model_path("spot")), 3);
  check_one_digest(refiner, all_variants(), refiner.digest_of({}));
}

TEST_CASE("Digest_CoveringVariantsOnEveryModel_IsOne") {
  int turn = 0;
  for (const std::string_view name : kModels) {
    const int at = turn++;
    DYNAMIC_SECTION(name) {
      if (!has_model(name)) continue;
      Refiner refiner(read_base_mesh(model_path(name)), 4);
      check_one_digest(refiner, covering_variants(at), refiner.digest_of({}));
    }
  }
}

TEST_CASE("SweepBudget_SmallestAndOnePageLess_FitsAndIsRefused") {
  if (!has_model("spot")) return;
  Refiner refiner(read_base_mesh(model_path("spot")), 4);
  for (const int threads : {1, 2}) {
    Variant variant;
    variant.block_bytes = 64 << 10;
    variant.threads = threads;
    const std::uint64_t smallest = refiner.sweep_budget(variant);
    REQUIRE(smallest > (64 << 10));
    CHECK_NOTHROW(refiner.refine(variant, smallest, {}));
    std::optional<ErrorCode> refused;
    try {
      refiner.refine(variant, smallest - kPageBytes, {});
    } catch (const Error& error) {
      refused = error.code();
    }
    CHECK(refused == ErrorCode::kBudget);
  }
}

TEST_CASE("Levels_EveryModelToLevelFive_HaveTheCountsBytesAndContentPromised") {
  constexpr int kLevels = 5;
  for (const std::string_view name : kModels) DYNAMIC_SECTION(name) {
      if (!has_model(name)) continue;
      Refiner refiner(read_base_mesh(model_path(name)), kLevels);
      Variant variant;
      const std::string expected = refiner.digest_of(variant);
      {
        const TemporaryDirectory directory;
        variant.backend = "pread";
        variant.layout = LayoutKind::kHilbert;
        constexpr std::uint64_t kBudgetBytes = 128 << 20;
        Store store = refiner.refine(variant, kBudgetBytes, directory.path() / "scratch.plait");
        check_levels(store, kLevels);
        CHECK(digest(store).to_string() == expected);
      }
      variant.backend = "compressed";
      variant.codec = "lz4";
      variant.layout = LayoutKind::kRcm;
      variant.block_bytes = 64 << 10;
      variant.budget = Budget::kSmallest;
      CHECK(refiner.digest_of(variant) == expected);
      if (is_full_run()) check_one_digest(refiner, all_variants(), expected);
    }
}
