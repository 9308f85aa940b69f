// A damaged store whose levels a program's own rule made: repaired with the rule, lost without it.
#include "plait/kernels/recompute_subdivision.h"

#include <catch2/catch.hpp>

#include "kernels/tension_rule.h"
#include "plait/backends/registry.h"
#include "plait/digest.h"
#include "plait/file.h"
#include "plait/kernels/own_rule.h"
#include "plait/kernels/subdivide.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

namespace fs = std::filesystem;

void flip(const fs::path& path, std::uint64_t offset) {
  File file(path, OpenMode::kReadWrite);
  std::byte value{};
  file.read_at(offset, std::span(&value, 1));
  value ^= std::byte{0x10};
  file.write_at(offset, std::span(&value, 1));
}

/// Three levels and normals by the tension rule, on disk.
class Victim {
 public:
  explicit Victim(ExecutorKind executor = ExecutorKind::kFused, bool double_precision = false) {
    const OneRingScheme scheme = own_scheme("tension", OwnTensionRule{});
    Store store =
        Store::create(path(), BaseMesh::build(random_sheet(11, 300)),
                      {.durability = Durability::kNone, .block_bytes = 4096}, default_backends());
    add_base_positions(store, double_precision);
    subdivide(store, {.own_scheme = &scheme, .executor = executor, .levels = 3, .normals = true});
    store.commit();
    digest_ = digest(store);
    first_block_ = store.level_file(0, 3).path;
  }
  fs::path path() const { return directory_.path() / "s.plait"; }
  void damage_blocks() const {
    flip(first_block_, 20);
    flip(path() / "attribute1.level02.1", 20);
  }
  void damage_files() const {
    fs::remove(path() / "attribute0.level02.1");
    flip(path() / "attribute0.base.1", 4);
  }
  bool is_as_before() const {
    Store store = Store::open(path(), {}, default_backends());
    return digest(store) == digest_;
  }
  RepairReport repair(const PlanRecomputation& recompute) const {
    return plait::repair(path(), {}, default_backends(), recompute);
  }

 private:
  TemporaryDirectory directory_;
  Digest digest_;
  fs::path first_block_;
};

}  // namespace

TEST_CASE("RepairOwnRule_WithTheRule_RebuildsBlocksAndFiles") {
  // The schemes that were handed in may be gone when repair() runs.
  const PlanRecomputation recompute = recompute_subdivision(
      {own_scheme("other", OwnTensionRule{0.1}), own_scheme("tension", OwnTensionRule{})});
  for (const ExecutorKind executor : {ExecutorKind::kFused, ExecutorKind::kSweep})
    for (const bool double_precision : {false, true}) {
      const Victim victim(executor, double_precision);
      victim.damage_blocks();
      victim.damage_files();
      const RepairReport report = victim.repair(recompute);
      CHECK(report.whole());
      CHECK(report.rebuilt_files.size() == 2);
      CHECK(report.rebuilt_count == 2);
      CHECK(victim.is_as_before());
    }
}

TEST_CASE("RepairOwnRule_WithoutTheRule_IsLostInWords") {
  const Victim victim;
  victim.damage_blocks();
  const RepairReport report = victim.repair(recompute_subdivision());
  CHECK(report.rebuilt_count == 0);
  REQUIRE(report.lost_count == 2);
  CHECK_THAT(report.lost[0].reason,
             Catch::Contains("the manifest's scheme 'tension' is none that can be repeated"));
  CHECK(victim.repair(recompute_subdivision({own_scheme("tension", OwnTensionRule{})})).whole());
}

TEST_CASE("RepairOwnRule_WithOtherFormulasOfThisName_IsLost") {
  const Victim victim;
  victim.damage_blocks();
  victim.damage_files();
  const PlanRecomputation other =
      recompute_subdivision({own_scheme("tension", OwnTensionRule{0.081})});
  CHECK(victim.repair(other).lost_files.size() == 2);
  CHECK(victim.repair(recompute_subdivision({own_scheme("tension", OwnTensionRule{})})).whole());
  CHECK(victim.is_as_before());
}

TEST_CASE("RepairSubdivision_LimitOfASchemeWithoutLimitPositions_IsLostInWords") {
  const Victim victim;
  {
    Store store = Store::open(victim.path(), {.writable = true}, default_backends());
    Provenance forged = store.provenance();
    forged.scheme = "butterfly";
    forged.limit = true;
    store.set_provenance(forged);
    store.commit();
  }
  victim.damage_blocks();
  const RepairReport report = victim.repair(recompute_subdivision());
  REQUIRE(report.lost_count == 2);
  CHECK_THAT(report.lost[0].reason, Catch::Contains("'butterfly' has no limit positions"));
}
