// plait repair: data that follows from the base mesh is restored to the last bit, other damaged
// data is named, and repair writes only bytes that a checksum proves. The test compares the digests
// before the damage and after the repair.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <map>
#include <string>
#include <vector>

#include "plait/extend/store_access.h"
#include "plait/mesh_io.h"
#include "plait/store.h"
#include "support/test_meshes.h"
#include "support/usable_backends.h"
#include "workplace.h"

namespace plait::test {
namespace {

namespace fs = std::filesystem;
struct RepairWorkplace : Workplace {
  explicit RepairWorkplace(const IndexedMesh& mesh = random_sphere(7, 300))
      : Workplace(Medium::kMemory) {
    write_ply(path("mesh.ply"), mesh);
  }
  /// Makes a store s.plait with blocks of 4 KiB. Returns its digest.
  std::string subdivide(const Words& options) const {
    succeed({"subdivide", "mesh.ply", "s.plait", "--levels", "3", "--block", "4KiB", "--force"},
            options);
    return digest();
  }
  std::string digest() const { return Workplace::digest("s.plait"); }
  Store open() const {
    return Store::open(path("s.plait"), {.writable = true, .budget_bytes = 8 << 20},
                       default_backends());
  }
  void flip(const std::string& file, std::streamoff offset) const {
    flip_byte(path("s.plait") / file, offset);
  }
  /// Every file of the store except the lock, into which each writer writes its process number.
  std::map<std::string, std::string> content() const {
    std::map<std::string, std::string> files;
    for (const std::string& name : names_in(path("s.plait")))
      if (name != "lock") files[name] = content_of(path("s.plait") / name);
    return files;
  }
  /// Repairs the store, and checks that its content is the same as before the damage.
  nlohmann::json repaired(const std::string& expected, const Words& options = {}) const {
    const Outcome outcome = succeed({"repair", "s.plait", "--json"}, options);
    CHECK(outcome.json()["ok"] == true);
    CHECK(plait({"verify", "s.plait"}).status == 0);
    CHECK(digest() == expected);
    CHECK(names_in(directory.path()) == Words{"mesh.ply", "s.plait"});
    return outcome.json();
  }
};

/// Damages every third block of the finest level and one block of the coarsest level, of positions
/// and of normals.
std::size_t damage_blocks(const RepairWorkplace& here) {
  std::vector<std::pair<std::string, std::streamoff>> places;
  {
    Store store = here.open();
    for (AttributeId id = 0; id < store.attributes().size(); ++id)
      for (const int level : {store.base_level() + 1, store.finest_level()}) {
        const LevelFile& file = StoreAccess::level_file(store, id, level);
        for (std::uint64_t block = 0; block < file.table.size(); block += 3) {
          places.emplace_back(file.path.filename(), file.table[block].offset + 5);
          if (level == store.base_level() + 1) break;
        }
      }
  }
  for (const auto& [file, offset] : places) here.flip(file, offset);
  return places.size();
}

void move_positions(Store& store, std::uint64_t first_block, std::uint64_t block_after) {
  LevelFile& file = StoreAccess::level_file(store, store.attribute("position"), 3);
  for (std::uint64_t block = first_block; block < std::min(block_after, file.table.size());
       ++block) {
    const PinnedBlock pinned = StoreAccess::open_session(store).pin(file, block, Access::kUpdate);
    const std::span<float> numbers(reinterpret_cast<float*>(pinned.bytes().data()),
                                   pinned.bytes().size() / sizeof(float));
    for (float& number : numbers) number *= 1.25f;
  }
  store.commit();
}

}  // namespace

TEST_CASE("Repair_DamagedBlocks_AreRebuiltInEveryBackend") {
  for (const std::string& backend : usable_backends()) {
    if (!default_backends().find(backend).traits.durable) continue;
    CAPTURE(backend);
    const RepairWorkplace here;
    const std::string expected = here.subdivide({"--backend", backend, "--normals"});
    const std::size_t damaged = damage_blocks(here);
    REQUIRE(damaged > 6);
    REQUIRE(here.plait({"verify", "s.plait"}).status == 1);
    const nlohmann::json report = here.repaired(expected);
    CHECK(report["rebuilt_count"] == damaged);
    CHECK(report["rebuilt"].size() == damaged);
    CHECK(report["version"] == 2);
    const std::string again = here.plait({"repair", "s.plait"}).output;
    CHECK(again.find("no damage, nothing to repair") != std::string::npos);
  }
}

TEST_CASE("Repair_EveryKindOfRefinement_IsRepeated") {
  const std::vector<Words> kinds = {
      {"--scheme", "midpoint"},
      {"--limit", "--normals"},
      {"--limit", "--backend", "compressed"},
      {"--precision", "float64", "--normals"},
      {"--executor", "transparent", "--layout", "rcm"},
      {"--max-slot", "64", "--normals"},
  };
  for (const bool border : {false, true}) {
    const RepairWorkplace here(border ? random_sheet(3, 250) : random_sphere(5, 250));
    for (const Words& kind : kinds) {
      CAPTURE(border, kind);
      const std::string expected = here.subdivide(kind);
      const std::size_t damaged = damage_blocks(here);
      CHECK(here.repaired(expected)["rebuilt_count"] == damaged);
    }
  }
}

TEST_CASE("Repair_OfWhatNoMakerMakes_IsLostInWordsAndLeavesTheStore") {
  const RepairWorkplace here;
  here.subdivide({"--scheme", "butterfly"});
  const std::size_t damaged = damage_blocks(here);
  const Outcome outcome = here.plait({"repair", "s.plait", "--json"});
  CHECK(outcome.status == 1);
  const nlohmann::json report = outcome.json();
  CHECK(report["lost_count"] == damaged);
  CHECK(report["lost"][0]["reason"].get<std::string>().find("by scheme 'butterfly'") !=
        std::string::npos);
  CHECK(report["version"] == 1);
}

TEST_CASE("Repair_OfPositionsThatAPassMade_SaysWhatMustRunAgain") {
  const RepairWorkplace here;
  here.subdivide({"--backend", "pread"});
  here.succeed({"pass", "s.plait", "smooth"});
  damage_blocks(here);
  const Outcome outcome = here.plait({"repair", "s.plait"});
  CHECK(outcome.status == 1);
  CHECK_THAT(outcome.output,
             Catch::Contains("attribute 'position', which a pass, an import or a "
                             "program has written: run that again on a whole store"));
}

TEST_CASE("Repair_NormalsOfMovedVertices_AreMadeAgainFromThePositions") {
  for (const Words& how : std::vector<Words>{{"--backend", "pread"},
                                             {"--backend", "pread", "--block", "1MiB"},
                                             {"--compress", "shuffle,zstd:1"}}) {
    CAPTURE(how);
    const RepairWorkplace here;
    here.subdivide({"--normals"});
    here.succeed({"displace", "s.plait", "moved.plait"}, how);
    fs::remove_all(here.path("s.plait"));
    fs::rename(here.path("moved.plait"), here.path("s.plait"));
    const std::string expected = here.digest();
    const auto damage = [&](const char* attribute) {
      std::vector<std::pair<std::string, std::streamoff>> places;
      {
        Store store = here.open();
        for (const int level : {1, 3}) {
          const LevelFile& file = StoreAccess::level_file(store, store.attribute(attribute), level);
          places.emplace_back(file.path.filename(), file.table[0].offset + 5);
        }
      }
      for (const auto& [file, offset] : places) here.flip(file, offset);
    };
    fs::copy(here.path("s.plait"), here.path("whole.plait"));
    damage("normal");
    const Outcome repaired = here.plait({"repair", "s.plait", "--json"});
    CHECK(repaired.status == 0);
    CHECK(repaired.json()["rebuilt_count"] == 2);
    CHECK(here.digest() == expected);
    CHECK(here.plait({"verify", "s.plait"}).status == 0);
    // Nothing makes the positions again, nor then the normals around them.
    fs::remove_all(here.path("s.plait"));
    fs::rename(here.path("whole.plait"), here.path("s.plait"));
    damage("position");
    damage("normal");
    const Outcome lost = here.plait({"repair", "s.plait", "--json"});
    CHECK(lost.status == 1);
    CHECK(lost.json()["lost_count"] == 4);
  }
}

TEST_CASE("Repair_WithLittleMemory_WorksBesideTheStore") {
  for (const std::string backend : {"pread", "compressed"}) {
    const RepairWorkplace here;
    const std::string expected = here.subdivide({"--backend", backend, "--normals"});
    damage_blocks(here);
    here.repaired(expected, {"--memory", "704KiB"});
  }
}

TEST_CASE("Repair_AnAttributeOfTheUsers_IsLostAndNamed") {
  const RepairWorkplace here;
  here.subdivide({});
  {
    Store store = here.open();
    const AttributeId mass = store.add_attribute({"mass", ComponentType::kFloat64, 1});
    store.add_level(mass);
    {
      const PinnedBlock pinned = StoreAccess::open_session(store).pin(
          StoreAccess::level_file(store, mass, 1), 0, Access::kOverwrite);
      std::ranges::fill(pinned.bytes(), std::byte{0x3f});
    }
    store.commit();
  }
  here.flip("attribute1.level01.2", 100);
  here.flip("attribute0.level03.1", 9000);
  const Outcome outcome = here.plait({"repair", "s.plait", "--json"});
  CHECK(outcome.status == 1);
  const nlohmann::json report = outcome.json();
  REQUIRE(report["lost_count"] == 1);
  CHECK(report["lost"][0]["attribute"] == "mass");
  CHECK(report["lost"][0]["level"] == 1);
  CHECK(report["lost"][0]["first_edge"] == 0);
  CHECK(report["rebuilt_count"] == 1);
  const nlohmann::json verified = here.plait({"verify", "s.plait", "--json"}).json();
  REQUIRE(verified["damaged_count"] == 1);
  CHECK(verified["damaged"][0]["attribute"] == "mass");
}

TEST_CASE("Repair_PositionsChangedInPlace_AreNotOverwritten") {
  for (const std::string backend : {"pread", "compressed"}) {
    CAPTURE(backend);
    const RepairWorkplace here;
    here.subdivide({"--backend", backend});
    {
      Store store = here.open();
      move_positions(store, 0, ~std::uint64_t{0});
    }
    std::uint64_t offset = 0;
    std::string name;
    {
      const Store store = here.open();
      const LevelFile& file = StoreAccess::level_file(store, 0, 3);
      offset = file.table[3].offset;
      name = file.table[3].file == kLogFile ? "changes.2" : file.path.filename().native();
    }
    here.flip(name, static_cast<std::streamoff>(offset) + 5);
    const auto before = here.content();
    const Outcome outcome = here.plait({"repair", "s.plait"});
    CHECK(outcome.status == 1);
    CHECK(outcome.output.find("lost: position, level 3, block ") == 0);
    CHECK(here.content() == before);
    CHECK(here.names() == Words{"mesh.ply", "s.plait"});
  }
}

TEST_CASE("Repair_OneBlockChanged_OthersComeBackAndItStays") {
  const RepairWorkplace here;
  const std::string pure = here.subdivide({});
  {
    Store store = here.open();
    move_positions(store, 2, 3);
  }
  const std::string expected = here.digest();
  REQUIRE(expected != pure);
  here.flip("attribute0.level03.1", 5);
  here.flip("attribute0.level03.1", 5 * 4096 + 7);
  CHECK(here.repaired(expected)["rebuilt_count"] == 2);
}

TEST_CASE("Repair_LevelFileThatIsGone_IsRebuiltBesideBlocksInTheChangeLog") {
  const RepairWorkplace here;
  here.subdivide({});
  {
    Store store = here.open();
    move_positions(store, 2, 3);
  }
  const std::string expected = here.digest();
  fs::remove(here.path("s.plait/attribute0.level03.1"));
  const nlohmann::json report = here.repaired(expected);
  REQUIRE(report["rebuilt_files"].size() == 1);
  CHECK(report["rebuilt_files"][0]["file"] == "attribute0.level03.1");
  // Nothing else says which blocks were in the log.
  fs::remove(here.path("s.plait/changes.2"));
  const Outcome outcome = here.plait({"repair", "s.plait"});
  CHECK(outcome.status == 1);
  CHECK(outcome.output.find("lost: changes.2") != std::string::npos);
}

TEST_CASE("Repair_DryRun_SaysWhatItWouldDoAndLeavesEveryByte") {
  const RepairWorkplace here;
  const std::string expected = here.subdivide({"--normals"});
  const std::size_t damaged = damage_blocks(here);
  const auto before = here.content();
  const std::string lock = content_of(here.path("s.plait/lock"));
  const Outcome outcome = here.plait({"repair", "s.plait", "--dry-run", "--json"});
  CHECK(outcome.status == 0);
  CHECK(outcome.json()["rebuilt_count"] == damaged);
  CHECK(outcome.json()["dry_run"] == true);
  CHECK(here.content() == before);
  CHECK(content_of(here.path("s.plait/lock")) == lock);
  CHECK(here.plait({"repair", "s.plait", "--dry-run"}).output.find("can be rebuilt: position") ==
        0);

  fs::remove(here.path("s.plait/attribute1.level03.1"));
  const auto without = here.content();
  const Outcome missing = here.plait({"repair", "s.plait", "--dry-run"});
  CHECK(missing.status == 0);
  CHECK(missing.output.find("can be rebuilt: attribute1.level03.1") == 0);
  CHECK(here.content() == without);
  CHECK(here.names() == Words{"mesh.ply", "s.plait"});
  here.repaired(expected);
}

TEST_CASE("Repair_DryRunWithADamagedFile_ReadsTheBlocksAsTheRepairDoes") {
  const RepairWorkplace here;
  here.subdivide({"--backend", "pread", "--normals"});
  std::string moved;
  std::streamoff place = 0;
  {
    Store store = here.open();
    move_positions(store, 0, 1);
    const LevelFile& file = StoreAccess::level_file(store, store.attribute("position"), 3);
    const BlockEntry& entry = file.table[0];
    moved = entry.file == kLogFile ? "changes.2"
                                   : fmt::format("attribute0.level03.{}", file.table.generation());
    place = static_cast<std::streamoff>(entry.offset);
  }
  here.flip(moved, place + 5);
  fs::remove(here.path("s.plait/attribute1.level02.1"));
  const auto before = here.content();
  for (const bool dry_run : {true, false}) {
    Words arguments = {"repair", "s.plait", "--json"};
    if (dry_run) arguments.push_back("--dry-run");
    const Outcome outcome = here.plait(arguments);
    CAPTURE(dry_run, outcome.errors, outcome.output);
    CHECK(outcome.status == 1);
    const nlohmann::json report = outcome.json();
    CHECK(report["blocks_read"] == true);
    CHECK(report["rebuilt_files"].size() == 1);
    CHECK(report["lost_count"] == 1);
    CHECK(report["lost"][0]["reason"].get<std::string>().find("s.plait/" + moved) !=
          std::string::npos);
    if (dry_run) CHECK(here.content() == before);
    CHECK(here.names() == Words{"mesh.ply", "s.plait"});
  }
}

TEST_CASE("Repair_FilesMissingOrShort_AreRebuilt") {
  for (const std::string backend : {"pread", "mmap", "compressed"}) {
    CAPTURE(backend);
    const RepairWorkplace here;
    const std::string expected = here.subdivide({"--backend", backend, "--normals", "--limit"});
    const auto before = here.content();
    fs::remove(here.path("s.plait/attribute1.level03.1"));
    fs::resize_file(here.path("s.plait/attribute0.level03.1"), 6000);
    fs::remove(here.path("s.plait/attribute1.base.1"));
    here.flip("attribute0.base.1", 17);
    here.flip("attribute0.level02.1", 17);
    const nlohmann::json found = here.plait({"verify", "s.plait", "--json"}).json();
    CHECK(found["damaged_files"].size() == 4);
    const nlohmann::json report = here.repaired(expected);
    CHECK(report["rebuilt_files"].size() == 4);
    CHECK(report["rebuilt_count"] == 1);
    for (const char* name : {"attribute1.level03.1", "attribute0.level03.1"})
      if (backend != "compressed") CHECK(here.content()[name] == before.at(name));
  }
}

TEST_CASE("Repair_WhatEverythingFollowsFrom_IsLostAndNothingChanges") {
  for (const std::string file : {"base.mesh", "version.1"}) {
    CAPTURE(file);
    const RepairWorkplace here;
    here.subdivide({});
    here.flip(file, 40);
    fs::remove(here.path("s.plait/attribute0.level02.1"));
    const auto before = here.content();
    const Outcome outcome = here.plait({"repair", "s.plait"});
    CHECK(outcome.status == 1);
    CHECK(outcome.output.find("lost: " + file) == 0);
    // Without the description no other file is known.
    CHECK((outcome.output.find("lost: attribute0.level02.1") != std::string::npos) ==
          (file == "base.mesh"));
    CHECK(here.content() == before);
  }
}

TEST_CASE("Repair_BlockTables_AreMadeAgainFromTheLevels") {
  for (const std::string backend : {"pread", "mmap"}) {
    CAPTURE(backend);
    const RepairWorkplace here;
    const std::string expected = here.subdivide({"--backend", backend, "--normals"});
    const auto before = here.content();
    const auto end = static_cast<std::streamoff>(fs::file_size(here.path("s.plait/version.1")));
    here.flip("version.1", end - 5);
    const Outcome dry = here.plait({"repair", "s.plait", "--dry-run"});
    CHECK(dry.status == 0);
    CHECK(dry.output.find("can be rebuilt: version.1") == 0);
    here.repaired(expected);
    CHECK(here.content() == before);

    here.flip("attribute1.level02.1", 100);
    fs::remove(here.path("s.plait/version.1"));
    const Outcome both = here.plait({"repair", "s.plait"});
    CHECK(both.status == 1);
    CHECK(both.output.find("lost: version.1") == 0);
    CHECK_FALSE(here.has("s.plait/version.1"));
  }
  const RepairWorkplace here;
  here.subdivide({"--backend", "compressed"});
  here.flip("version.1", 100);
  CHECK(here.plait({"repair", "s.plait"}).status == 1);
}

TEST_CASE("Repair_ManifestSlotDamaged_IsReportedAndHarmless") {
  const RepairWorkplace here;
  const std::string expected = here.subdivide({});
  {
    Store store = here.open();
    StoreAccess::set_provenance(store, store.provenance());
    store.commit();
  }
  here.flip("manifest", 4096 + 50);  // the older version's
  const nlohmann::json report = here.plait({"repair", "s.plait", "--json"}).json();
  CHECK(report["ok"] == true);
  CHECK(report["version"] == 2);
  REQUIRE(report["notes"].size() == 1);
  CHECK(here.digest() == expected);
  here.flip("manifest", 60);
  CHECK(here.plait({"repair", "s.plait"}).status == 1);
}

}  // namespace plait::test
