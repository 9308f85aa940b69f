// Refines generated and real meshes. Tests the number of vertices and of bytes, and that backend,
// executor and layout do not change the content.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <filesystem>
#include <optional>
#include <set>
#include <utility>

#include "acceptance/meshes.h"
#include "acceptance/variants.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/extend/store_access.h"
#include "plait/registry.h"
#include "plait/verify.h"
#include "support/temporary_directory.h"
#include "support/usable_backends.h"

using namespace plait;
using namespace plait::test;

namespace {

/// The size of a level file is a multiple of a page.
constexpr std::uint64_t kPageBytes = 4096;
constexpr std::uint64_t kRecordBytes = 12;

struct Counts {
  std::uint64_t vertices, edges, faces;
};

/// A refinement divides each edge into two and each face into four. Three new edges are inside each
/// old face.
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

/// Checks every level file of every attribute of a committed `pread` store: it has as many records
/// as the formulas give, each written once, and no other byte except the padding of a page.
void check_levels(Store& store, int levels) {
  const BaseMesh& base = store.base();
  Counts counts = counts_of(base);
  for (AttributeId id = 0; id < store.attributes().size(); ++id)
    CHECK(std::as_const(store).base_bytes(id).size() == counts.vertices * kRecordBytes);
  std::uint64_t stored_vertices = counts.vertices;
  for (int level = 1; level <= levels; ++level) {
    INFO("level " << level);
    const std::uint64_t born = counts.edges;
    counts = refined(counts);
    for (AttributeId id = 0; id < store.attributes().size(); ++id) {
      const LevelFile& file = StoreAccess::level_file(store, id, level);
      if (base.border_edge_count() == 0)
        CHECK(file.geometry.total_bytes() ==
              (base.edge_count() << (2 * (level - 1))) * kRecordBytes);
      CHECK(file.geometry.total_bytes() == born * kRecordBytes);
      const std::uint64_t file_bytes = std::filesystem::file_size(file.path);
      CHECK(file_bytes >= file.geometry.total_bytes());
      CHECK(file_bytes < file.geometry.total_bytes() + kPageBytes);
    }
    stored_vertices +=
        StoreAccess::level_file(store, 0, level).geometry.total_bytes() / kRecordBytes;
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

Refiner refiner_of(const AcceptanceMesh& mesh, int levels) {
  return {BaseMesh::build(mesh.make()), levels};
}

/// Runs covering_variants(turn) on the mesh number `turn`.
void check_covering_variants(const std::vector<AcceptanceMesh>& meshes, int levels) {
  for (std::size_t turn = 0; turn < meshes.size(); ++turn) {
    INFO(meshes[turn].name);
    Refiner refiner = refiner_of(meshes[turn], levels);
    check_one_digest(refiner, covering_variants(static_cast<int>(turn)), refiner.digest_of({}));
  }
}

/// Refines in memory, in plain files with another layout, and compressed with a third layout.
void check_counts_bytes_and_content(const AcceptanceMesh& mesh, int levels) {
  INFO(mesh.name << " to level " << levels);
  Refiner refiner = refiner_of(mesh, levels);
  Variant variant;
  const std::string expected = refiner.digest_of(variant);
  {
    const TemporaryDirectory directory;
    variant.backend = "pread";
    variant.layout = LayoutKind::kHilbert;
    constexpr std::uint64_t kBudgetBytes = 128 << 20;
    Store store = refiner.refine(variant, kBudgetBytes, directory.path() / "scratch.plait");
    check_levels(store, levels);
    CHECK(digest(store).to_string() == expected);
  }
  variant.backend = "compressed";
  variant.codec = "lz4";
  variant.layout = LayoutKind::kRcm;
  variant.block_bytes = 64 << 10;
  variant.budget = BudgetSize::kSmallest;
  CHECK(refiner.digest_of(variant) == expected);
  if (is_full_run()) check_one_digest(refiner, all_variants(), expected);
}

std::uint64_t count_components(const Topology& mesh) {
  std::vector<bool> seen(mesh.faces.size(), false);
  std::uint64_t components = 0;
  for (FaceId seed = 0; seed < mesh.faces.size(); ++seed) {
    if (seen[seed]) continue;
    ++components;
    seen[seed] = true;
    for (std::vector<FaceId> stack = {seed}; !stack.empty();) {
      const FaceId face = stack.back();
      stack.pop_back();
      for (const int side : {0, 1, 2}) {
        const FaceSide beyond = mesh.across(FaceSide(face, side));
        if (!beyond.exists() || seen[beyond.face()]) continue;
        seen[beyond.face()] = true;
        stack.push_back(beyond.face());
      }
    }
  }
  return components;
}

}  // namespace

TEST_CASE("AcceptanceMeshes_GeneratedOnes_CoverComponentsBordersGenusAndValences") {
  struct Kind {
    const char* name;
    std::uint64_t components;
    bool has_border;
    std::int64_t most_euler;
  };
  const std::vector<AcceptanceMesh> meshes = generated_meshes(2000);
  const Kind expected[] = {
      {"molecule", 1, false, 2},
      {"open sheet", 1, true, 1},
      {"torus", 1, false, 0},
      {"icosphere", 1, false, 2},
      {"molecule with holes", 1, true, -7},
      // Molecule, sheet, torus, tetrahedron, triangle, fan, bipyramid, annulus.
      {"components", 8, true, 2 + 1 + 0 + 2 + 1 + 1 + 2 + 0}};
  REQUIRE(meshes.size() == std::size(expected));
  std::uint64_t lowest_valence = 99, highest_valence = 0;
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    INFO(meshes[i].name);
    const BaseMesh mesh = BaseMesh::build(meshes[i].make());
    CHECK(meshes[i].name == expected[i].name);
    CHECK(count_components(mesh.topology()) == expected[i].components);
    CHECK((mesh.border_edge_count() > 0) == expected[i].has_border);
    const auto euler = static_cast<std::int64_t>(mesh.vertex_count() + mesh.face_count()) -
                       static_cast<std::int64_t>(mesh.edge_count());
    CHECK(euler <= expected[i].most_euler);
    std::vector<std::uint64_t> valence(mesh.vertex_count(), 0);
    for (const Edge& edge : mesh.edges()) ++valence[edge.start], ++valence[edge.end];
    lowest_valence = std::min(lowest_valence, std::ranges::min(valence));
    highest_valence = std::max(highest_valence, std::ranges::max(valence));
  }
  CHECK(lowest_valence == 2);
  CHECK(highest_valence == 40);
}

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
  // The compressed backend counts twice, once per codec.
  const std::size_t backends = usable_backends().size() + 1;
  CHECK(covering.size() == 6 * backends);
  CHECK(all_variants().size() == 96 * backends);
  for (std::size_t a = 1; a <= kLayout; ++a)
    for (std::size_t b = 0; b < a; ++b)
      if (b == kBackend || a != kLayout)
        CHECK(pairs_of(covering, a, b) == pairs_of(all_variants(), a, b));
}

TEST_CASE("Digest_FullProductOnManyComponents_IsOne") {
  Refiner refiner = refiner_of(generated_meshes(600).back(), 3);
  check_one_digest(refiner, all_variants(), refiner.digest_of({}));
}

TEST_CASE("Digest_CoveringVariantsOnGeneratedMeshes_IsOne") {
  check_covering_variants(generated_meshes(2000), 4);
}

TEST_CASE("Digest_CoveringVariantsOnRealMeshes_IsOne", "[real-meshes]") {
  check_covering_variants(real_meshes(), is_full_run() ? 4 : 2);
}

TEST_CASE("SweepBudget_SmallestAndOnePageLess_FitsAndIsRefused") {
  Refiner refiner = refiner_of(generated_meshes(2000).front(), 4);
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

TEST_CASE("Levels_OfGeneratedMeshes_HaveTheCountsBytesAndContentPromised") {
  for (const AcceptanceMesh& mesh : generated_meshes(1500)) check_counts_bytes_and_content(mesh, 5);
}

// A mesh of the size that plait is made for.
TEST_CASE("Levels_OfALargeMolecule_HaveTheCountsBytesAndContentPromised") {
  check_counts_bytes_and_content(generated_meshes(26'016).front(), is_full_run() ? 5 : 4);
}

TEST_CASE("Levels_OfRealMeshes_HaveTheCountsBytesAndContentPromised", "[real-meshes]") {
  for (const AcceptanceMesh& mesh : real_meshes())
    check_counts_bytes_and_content(mesh, is_full_run() ? 5 : 3);
}
