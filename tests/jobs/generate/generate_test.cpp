#include "generate/generate.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "plait/error.h"

using namespace plait;
using Catch::Contains;

namespace {

constexpr std::array kKinds{GeneratorKind::kMolecule, GeneratorKind::kTorus,
                            GeneratorKind::kIcosphere, GeneratorKind::kOpenSheet};

BaseMesh build_without_warnings(IndexedMesh mesh) {
  std::vector<std::string> warnings;
  BaseMesh built = BaseMesh::build(std::move(mesh), "generated", &warnings);
  CHECK(warnings.empty());
  return built;
}

std::vector<int> valences(const BaseMesh& mesh) {
  std::vector<int> valence(mesh.vertex_count(), 0);
  for (const Edge& edge : mesh.edges()) {
    ++valence[edge.start];
    ++valence[edge.end];
  }
  return valence;
}

void check_promises(const BaseMesh& mesh, GeneratorKind kind) {
  const long euler = static_cast<long>(mesh.vertex_count()) - static_cast<long>(mesh.edge_count()) +
                     static_cast<long>(mesh.face_count());
  CHECK((mesh.border_edge_count() > 0) == (kind == GeneratorKind::kOpenSheet));
  switch (kind) {
    case GeneratorKind::kMolecule:
      CHECK(euler <= 2);
      CHECK(euler % 2 == 0);
      break;
    case GeneratorKind::kTorus:
      CHECK(euler == 0);
      break;
    case GeneratorKind::kIcosphere:
      CHECK(euler == 2);
      break;
    case GeneratorKind::kOpenSheet:
      CHECK(euler == 1);
      break;
  }
  const std::vector<int> valence = valences(mesh);
  CHECK(*std::min_element(valence.begin(), valence.end()) >=
        (kind == GeneratorKind::kOpenSheet ? 2 : 3));
}

bool are_equal(const IndexedMesh& a, const IndexedMesh& b) {
  return a.positions == b.positions && a.faces == b.faces;
}

std::uint64_t count_components(const BaseMesh& mesh) {
  std::vector<bool> visited(mesh.face_count(), false);
  std::uint64_t components = 0;
  for (FaceId seed = 0; seed < visited.size(); ++seed) {
    if (visited[seed]) continue;
    ++components;
    std::vector<FaceId> stack{seed};
    visited[seed] = true;
    while (!stack.empty()) {
      const FaceId face = stack.back();
      stack.pop_back();
      for (int side = 0; side < 3; ++side) {
        const FaceSide beyond = mesh.topology().across(FaceSide(face, side));
        if (!beyond.exists() || visited[beyond.face()]) continue;
        visited[beyond.face()] = true;
        stack.push_back(beyond.face());
      }
    }
  }
  return components;
}

}  // namespace

TEST_CASE("Generate_EveryKindAtManyCountsAndSeeds_HoldsItsPromises") {
  for (const GeneratorKind kind : kKinds) {
    const std::uint64_t fewest = vertex_count_range(kind).fewest;
    for (const std::uint64_t more : {0u, 1u, 2u, 3u, 5u, 8u, 30u, 51u, 100u, 999u, 4000u}) {
      for (const std::uint64_t seed : {0u, 1u, 77u}) {
        INFO(to_string(kind) << " " << fewest + more << " seed " << seed);
        const BaseMesh mesh = build_without_warnings(generate(kind, fewest + more, seed));
        CHECK(mesh.vertex_count() == fewest + more);
        CHECK(count_components(mesh) == 1);
        check_promises(mesh, kind);
      }
    }
  }
}

TEST_CASE("Generate_SizeOfTheReferenceMolecule_IsExactAndIrregular") {
  const BaseMesh mesh = build_without_warnings(generate(GeneratorKind::kMolecule, 26016, 1));
  CHECK(mesh.vertex_count() == 26016);
  check_promises(mesh, GeneratorKind::kMolecule);
  const std::vector<int> valence = valences(mesh);
  const auto share = [&](int wanted) {
    return static_cast<double>(std::count(valence.begin(), valence.end(), wanted)) / 26016;
  };
  for (const int irregular : {4, 5, 7, 8}) CHECK(share(irregular) > 0.01);
  CHECK(share(6) > 0.3);
}

TEST_CASE("Generate_SameSeed_GivesTheSameMeshAndAnotherSeedAnother") {
  for (const GeneratorKind kind : kKinds) {
    for (const std::uint64_t vertices : {162u, 700u}) {
      INFO(to_string(kind) << " " << vertices);
      const IndexedMesh mesh = generate(kind, vertices, 5);
      CHECK(are_equal(mesh, generate(kind, vertices, 5)));
      CHECK_FALSE(are_equal(mesh, generate(kind, vertices, 6)));
    }
  }
}

TEST_CASE("Generate_IcosphereOfAGeodesicCount_HasTwelveVerticesOfValenceFive") {
  for (const std::uint64_t frequency : {1u, 2u, 3u, 4u, 9u, 16u}) {
    const std::uint64_t vertices = 10 * frequency * frequency + 2;
    const BaseMesh mesh = build_without_warnings(generate(GeneratorKind::kIcosphere, vertices, 3));
    const std::vector<int> valence = valences(mesh);
    CHECK(std::count(valence.begin(), valence.end(), 5) == 12);
    CHECK(std::count(valence.begin(), valence.end(), 6) ==
          static_cast<std::ptrdiff_t>(vertices - 12));
  }
}

TEST_CASE("Generate_ClosedKinds_AreOrientedOutwards") {
  for (const GeneratorKind kind :
       {GeneratorKind::kMolecule, GeneratorKind::kTorus, GeneratorKind::kIcosphere}) {
    const IndexedMesh mesh = generate(kind, 1000, 2);
    double volume = 0;
    for (const auto& [a, b, c] : mesh.faces)
      volume += dot(mesh.positions[a], cross(mesh.positions[b], mesh.positions[c])) / 6;
    CHECK(volume > 0);
  }
}

TEST_CASE("Generate_Positions_AreFloat32Values") {
  for (const GeneratorKind kind : kKinds)
    for (const Vector3<double>& position : generate(kind, 300, 1).positions)
      for (int axis = 0; axis < 3; ++axis)
        CHECK(static_cast<double>(static_cast<float>(position[axis])) == position[axis]);
}

TEST_CASE("Generate_CountOutOfRange_IsRefusedNamingTheRange") {
  for (const GeneratorKind kind : kKinds) {
    const auto [fewest, most] = vertex_count_range(kind);
    CHECK_THROWS_WITH(generate(kind, fewest - 1, 1),
                      Contains(std::string(to_string(kind))) && Contains(std::to_string(fewest)));
    CHECK_THROWS_WITH(generate(kind, most + 1, 1), Contains(std::to_string(most)));
    CHECK_THROWS_AS(generate(kind, 0, 1), Error);
  }
}

TEST_CASE("Generate_Progress_RisesFromZeroToOneAndItsExceptionsPass") {
  for (const GeneratorKind kind : kKinds) {
    std::vector<double> fractions;
    generate(kind, 20000, 1, [&](double fraction) { fractions.push_back(fraction); });
    REQUIRE(fractions.size() >= 3);
    CHECK(std::is_sorted(fractions.begin(), fractions.end()));
    CHECK(fractions.front() == 0);
    CHECK(fractions.back() == 1);
    CHECK_THROWS_AS(generate(kind, 1000, 1,
                             [](double fraction) {
                               if (fraction > 0) throw Error(ErrorCode::kCancelled, "enough");
                             }),
                    Error);
  }
}

TEST_CASE("GeneratorNames_EveryKind_ReadsBackAndOthersAreRefused") {
  for (const GeneratorKind kind : kKinds) CHECK(generator_from_name(to_string(kind)) == kind);
  CHECK_THROWS_WITH(generator_from_name("teapot"), Contains("open-sheet") && Contains("teapot"));
}
