// What passes will need, against what they are told to need, and get, where the levels are there.
#include "execution/pin_needs.h"

#include <catch2/catch.hpp>
#include <vector>

#include "engine/store/sample_store.h"
#include "plait/error.h"
#include "plait/extend/patch.h"
#include "plait/registry.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

constexpr int kPinLevels = 5;

BaseMesh some_mesh(std::uint64_t seed) {
  return BaseMesh::build(seed == 1   ? random_sheet(seed, 400)
                         : seed == 2 ? random_torus(seed, 400)
                                     : random_sphere(seed, 400));
}

Store make_store(const std::filesystem::path& path, const BaseMesh& base, int base_level,
                 std::uint64_t budget_bytes) {
  return Store::create(path, base, {.block_bytes = 4096, .budget_bytes = budget_bytes},
                       default_backends(), {.base_level = base_level});
}

}  // namespace

TEST_CASE("SweepNeeds_OfLevelsToCome_AreTheWindowOfThoseThatAreThere") {
  for (const std::uint64_t seed : {1u, 2u, 3u})
    for (const int base_level : {0, 2}) {
      const TemporaryDirectory directory(Medium::kMemory);
      Store store = make_store(directory.path() / "s.plait", some_mesh(seed), base_level, 16 << 20);
      const std::vector<std::vector<AccessedLevels>> passes = {
          {{12, base_level + 1, base_level + kPinLevels, Reach::kFaces}},
          {{12, base_level + 1, base_level + kPinLevels - 1, Reach::kRing},
           {12, base_level + kPinLevels, base_level + kPinLevels, Reach::kOwn}},
          {{24, 1, 0, Reach::kFaces}, {12, base_level + 2, base_level + 3, Reach::kOwn}}};
      std::vector<std::vector<std::uint64_t>> told;
      for (const auto& accesses : passes)
        for (const int threads : {1, 2, 17})
          told.push_back({sweep_needs(store, accesses, threads)});
      const AttributeId position = store.add_attribute(schema_of<Vector3<float>>("position"));
      for (int level = 0; level < kPinLevels; ++level) store.add_level(position);
      std::size_t at = 0;
      for (const auto& accesses : passes)
        for (const int threads : {1, 2, 17}) {
          SweepPass pass;
          for (const AccessedLevels& access : accesses)
            pass.accesses.push_back(
                {position, access.first_level, access.last_level, Access::kRead, access.reach});
          CAPTURE(seed, base_level, threads, at);
          CHECK(told[at++].front() == sweep_window_bytes(store, pass, threads));
        }
    }
}

TEST_CASE("PatchNeeds_OfLevelsToCome_AreTheSmallestBudgetThatDoes") {
  int tight = 0;
  for (const std::uint64_t seed : {1u, 2u, 3u})
    for (const Reach reach : {Reach::kFaces, Reach::kRing}) {
      const TemporaryDirectory directory(Medium::kMemory);
      const BaseMesh base = some_mesh(seed);
      const std::filesystem::path path = directory.path() / "s.plait";
      std::uint64_t needed = 0;
      {
        Store store = make_store(path, base, 0, 16 << 20);
        needed = patch_needs(store, {12, 1, kPinLevels, reach});
        const AttributeId position = store.add_attribute(schema_of<Vector3<float>>("position"));
        for (int level = 0; level < kPinLevels; ++level) store.add_level(position);
        store.commit();
      }
      const auto walk = [&](std::uint64_t budget_bytes) {
        const OpenOptions open{.budget_bytes = budget_bytes, .io_threads = 0};
        Store store = Store::open(path, open, default_backends());
        StorePatches<Vector3<float>> patches(store, 0, 0, reach);
        patches.activate(kPinLevels, 1, 0);
        for (FaceId face = 0; face < base.face_count(); ++face) patches.patch(face);
      };
      CAPTURE(seed, static_cast<int>(reach), needed);
      CHECK_NOTHROW(walk(std::max<std::uint64_t>(needed, 64 << 10)));
      if (needed <= (64 << 10)) continue;
      ++tight;
      CHECK_THROWS_AS(walk(needed - 4096), Error);
    }
  CHECK(tight > 0);
}

}  // namespace plait::test
