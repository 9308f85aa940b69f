// A damaged store whose levels a program's own rule made: repaired with the rule, lost without it.
#include <catch2/catch.hpp>

#include "kernels/tension_rule.h"
#include "plait/digest.h"
#include "plait/extend/block_makers.h"
#include "plait/extend/file.h"
#include "plait/extend/store_access.h"
#include "plait/own_rule.h"
#include "plait/registry.h"
#include "plait/subdivide.h"
#include "plait/verify.h"
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
    add_base_positions(store, double_precision ? ComponentType::kFloat64 : ComponentType::kFloat32);
    subdivide(store, {.scheme = scheme, .executor = executor, .levels = 3, .normals = true});
    store.commit();
    digest_ = digest(store);
    first_block_ = StoreAccess::level_file(store, 0, 3).path;
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
  RepairReport repair(const std::shared_ptr<const BlockMakers>& makers) const {
    return plait::repair(path(), {}, default_backends(), makers);
  }

 private:
  TemporaryDirectory directory_;
  Digest digest_;
  fs::path first_block_;
};

}  // namespace

TEST_CASE("RepairOwnRule_WithTheRule_RebuildsBlocksAndFiles") {
  // The schemes that were handed in may be gone when repair() runs.
  const auto makers = subdivision_block_makers(
      {own_scheme("other", OwnTensionRule{0.1}), own_scheme("tension", OwnTensionRule{})});
  for (const ExecutorKind executor : {ExecutorKind::kFused, ExecutorKind::kSweep})
    for (const bool double_precision : {false, true}) {
      const Victim victim(executor, double_precision);
      victim.damage_blocks();
      victim.damage_files();
      const RepairReport report = victim.repair(makers);
      CHECK(report.whole());
      CHECK(report.rebuilt_files.size() == 2);
      CHECK(report.rebuilt_count == 2);
      CHECK(victim.is_as_before());
    }
}

TEST_CASE("RepairOwnRule_WithoutTheRule_IsLostInWords") {
  const Victim victim;
  victim.damage_blocks();
  const RepairReport report = victim.repair(subdivision_block_makers());
  CHECK(report.rebuilt_count == 0);
  REQUIRE(report.lost_count == 2);
  CHECK_THAT(report.lost[0].reason,
             Catch::Contains("no maker makes attribute 'position' again by scheme 'tension'"));
  CHECK(victim.repair(subdivision_block_makers({own_scheme("tension", OwnTensionRule{})})).whole());
}

TEST_CASE("RepairOwnRule_WithOtherFormulasOfThisName_IsLost") {
  const Victim victim;
  victim.damage_blocks();
  victim.damage_files();
  const auto other = subdivision_block_makers({own_scheme("tension", OwnTensionRule{0.081})});
  CHECK(victim.repair(other).lost_files.size() == 2);
  CHECK(victim.repair(subdivision_block_makers({own_scheme("tension", OwnTensionRule{})})).whole());
  CHECK(victim.is_as_before());
}

TEST_CASE("RepairSubdivision_OfASchemeThatNoMakerKnows_IsLostInWords") {
  const Victim victim;
  {
    Store store = Store::open(victim.path(), {.writable = true}, default_backends());
    Provenance forged = store.provenance();
    forged.scheme = "butterfly";
    StoreAccess::set_provenance(store, forged);
    store.commit();
  }
  victim.damage_blocks();
  const RepairReport report = victim.repair(library_block_makers());
  REQUIRE(report.lost_count == 2);
  CHECK_THAT(report.lost[0].reason, Catch::Contains("by scheme 'butterfly'"));
  CHECK(victim.repair({}).lost_count == 2);
}
