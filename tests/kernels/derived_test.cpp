// Attributes that are not stored, but computed when they are read: the records that the stored
// attribute has, on every backend, also after changes of what they are computed from.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "engine/store/forge.h"
#include "plait/backends/registry.h"
#include "plait/copy_levels.h"
#include "plait/derivation.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/kernels/displace.h"
#include "plait/kernels/subdivide.h"
#include "plait/kernels/visit_vertices.h"
#include "plait/reader.h"
#include "plait/recode_attribute.h"
#include "plait/repair.h"
#include "plait/verify.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"
#include "support/usable_backends.h"

namespace plait::test::derived_test {
namespace {

namespace fs = std::filesystem;
using DerivedPoint = Vector3<float>;

struct Surface {
  BaseMesh base;
  int levels = 3;
  int base_level = 0;
  bool double_precision = false;
  bool displaced = true;
};

StoreOptions options_for(const std::string& backend, int base_level = 0) {
  StoreOptions options;
  options.backend = backend;
  if (backend == "compressed") options.pipeline = "hierarchy+shuffle,zstd:1";
  options.block_bytes = 4096;
  options.budget_bytes = 16 << 20;
  options.base_level = base_level;
  options.durability = Durability::kNone;
  return options;
}

/// Positions and stored normals.
Store stored(const fs::path& path, const Surface& surface, const std::string& backend) {
  StoreOptions options = options_for(backend, surface.base_level);
  if (backend == "compressed") options.pipeline = "shuffle,zstd:1";
  Store store = Store::create(path, surface.base, options, default_backends());
  add_base_positions(store, surface.double_precision);
  SubdivideOptions how;
  how.levels = surface.levels;
  how.normals = true;
  subdivide(store, how);
  if (surface.displaced) displace(store, {.amplitude = 1e-3, .threads = 2});
  store.commit();
  return store;
}

Store derived_in_memory(const Surface& surface) { return stored({}, surface, "memory"); }

void derive(Store& store, const char* name = "normal") {
  recode_attribute(store, store.attribute(name), "derived");
}

Surface derived_torus(int levels = 3) { return {BaseMesh::build(torus_grid(9, 7)), levels}; }

std::vector<std::byte> block_of(const Store& store, const char* name, int level,
                                std::uint64_t block) {
  const PinnedBlock pinned =
      store.open_session().pin(store.level_file(store.attribute(name), level), block);
  return {pinned.bytes().begin(), pinned.bytes().end()};
}

/// Moves one vertex of the finest level, in place.
void move_a_vertex(Store& store, float by) {
  const AttributeId position = store.attribute("position");
  LevelFile& level = store.level_file(position, store.finest_level());
  const PinnedBlock pinned = store.open_session().pin(level, 0, Access::kUpdate);
  reinterpret_cast<DerivedPoint*>(pinned.bytes().data())->x += by;
}

/// The normals of the store's present positions, stored in another attribute by a pass that has
/// nothing to do with derived attributes.
std::string digest_with_new_normals(Store& store) {
  Store copy = Store::create({}, store.base(), options_for("memory"), default_backends());
  copy_attribute(store, store.attribute("position"), copy,
                 copy.add_attribute(schema_of<DerivedPoint>("position")));
  copy.add_attribute(schema_of<DerivedPoint>("normal"), store.finest_level());
  displace(copy, {.amplitude = 0});
  return digest(copy).to_string();
}

std::uint64_t files_of(const fs::path& store, std::string_view attribute) {
  std::uint64_t count = 0;
  for (const auto& entry : fs::directory_iterator(store))
    count += entry.path().filename().native().starts_with(attribute) ? 1u : 0u;
  return count;
}

}  // namespace

TEST_CASE("Derived_NormalsOnEveryBackend_HaveTheBitsOfStoredOnesAndNoFile") {
  const std::vector<std::pair<std::string, Surface>> surfaces = [] {
    std::vector<std::pair<std::string, Surface>> all;
    all.emplace_back("torus", derived_torus(3));
    all.emplace_back("of Loop alone", derived_torus(2));
    all.back().second.displaced = false;
    all.emplace_back("with borders", Surface{BaseMesh::build(random_sheet(11, 80))});
    all.emplace_back("with a hub", Surface{BaseMesh::build(closed_fan(300)), 2});
    all.emplace_back("one face", Surface{BaseMesh::build(single_triangle()), 5});
    all.emplace_back("float64", derived_torus(2));
    all.back().second.double_precision = true;
    all.emplace_back("rebased", Surface{BaseMesh::build(torus_grid(5, 4)), 3, 1});
    all.emplace_back("no level", derived_torus(0));
    all.back().second.displaced = false;
    return all;
  }();
  for (const auto& [name, surface] : surfaces) {
    Store expected = derived_in_memory(surface);
    const std::string word = digest(expected).to_string();
    for (const std::string& backend : usable_backends()) {
      CAPTURE(name, backend);
      const bool on_disk = backend != "memory";
      const TemporaryDirectory directory(Medium::kMemory);
      const fs::path path = on_disk ? directory.path() / "s.plait" : fs::path();
      Store store = stored(path, surface, backend);
      const std::uint64_t before = store.stored_bytes();
      derive(store);
      store.commit();
      CHECK(store.derivation(store.attribute("normal")) == "normals/position");
      CHECK(store.stored_bytes() < before);
      CHECK(digest(store).to_string() == word);
      if (on_disk) {
        store.close();
        // Displaced positions have a number of their own, and each encoding of normals has another.
        CHECK(files_of(path, surface.displaced ? "attribute2." : "attribute0.") > 0);
        CHECK(files_of(path, surface.displaced ? "attribute3." : "attribute2.") == 0);
        store = Store::open(path, {.writable = true}, default_backends());
        CHECK(digest(store, {.threads = 3}).to_string() == word);
      }
      const VerifyReport report = verify(store);
      CHECK(report.damaged_count == 0);
      CHECK(report.never_written == 0);
      recode_attribute(store, store.attribute("normal"),
                       backend == "compressed" ? "shuffle,zstd:1" : "none");
      store.commit();
      CHECK(store.derivation(store.attribute("normal")).empty());
      CHECK(digest(store).to_string() == word);
    }
  }
}

TEST_CASE("Derived_BlockBeforeAndAfterAChangeOfPositions_IsThatOfItsTime") {
  const std::string backend = GENERATE(as<std::string>(), "memory", "pread", "compressed");
  CAPTURE(backend);
  const TemporaryDirectory directory(Medium::kMemory);
  const bool on_disk = backend != "memory";
  Store store =
      stored(on_disk ? directory.path() / "s.plait" : fs::path(), derived_torus(), backend);
  derive(store);
  store.commit();
  const AttributeId normal = store.attribute("normal");
  const int finest = store.finest_level();
  for (const bool commits : {false, true}) {
    const PinnedBlock before =
        store.open_session().pin(std::as_const(store).level_file(normal, finest), 0);
    const std::vector<std::byte> kept(before.bytes().begin(), before.bytes().end());
    move_a_vertex(store, 0.5f);
    CHECK(std::ranges::equal(before.bytes(), kept));  // a pin keeps its bytes
    CHECK(block_of(store, "normal", finest, 0) != kept);
    CHECK(digest(store).to_string() == digest_with_new_normals(store));
    if (commits) store.commit();
  }
  // A base vertex moves the normals of base vertices and of those beside it.
  store.base_records<DerivedPoint>(store.attribute("position"))[3].y += 0.25f;
  CHECK(digest(store).to_string() == digest_with_new_normals(store));
  store.commit();
  const std::string word = digest(store).to_string();
  if (!on_disk) return;
  store.close();
  Store again = Store::open(directory.path() / "s.plait", {}, default_backends());
  CHECK(digest(again).to_string() == word);
}

TEST_CASE("Derived_ReadWhilePositionsAreWritten_IsRefused") {
  Store store = derived_in_memory(derived_torus());
  derive(store);
  const AttributeId normal = store.attribute("normal"), position = store.attribute("position");
  const Store& reading = store;
  const auto read = [&] { store.open_session().pin(reading.level_file(normal, 1), 0); };
  {
    const PinnedBlock written =
        store.open_session().pin(store.level_file(position, 3), 0, Access::kUpdate);
    const Error error = error_of(read);
    CHECK(error.code() == ErrorCode::kBadState);
    CHECK_THAT(error.what(), Catch::Contains("nobody writes"));
  }
  CHECK_NOTHROW(read());
  // A pass that would read normals of vertices that it moves.
  const Error error = error_of([&] {
    visit_vertices(
        store, {.name = "inflate"},
        std::tuple{updates<DerivedPoint>("position"), reads<DerivedPoint>("normal")},
        [](const VertexRun&, std::span<DerivedPoint> p, std::span<const DerivedPoint> n) {
          for (std::size_t i = 0; i < p.size(); ++i) p[i] = p[i] + n[i];
        });
  });
  CHECK(error.code() == ErrorCode::kBadState);
}

TEST_CASE("Derived_Writing_IsRefusedAndNamesTheWayOut") {
  const TemporaryDirectory directory(Medium::kMemory);
  Store store = stored(directory.path() / "s.plait", derived_torus(), "pread");
  derive(store);
  store.commit();
  const std::string word = digest(store).to_string();
  const AttributeId normal = store.attribute("normal");
  const std::vector<std::function<void()>> writes = {
      [&] { store.open_session().pin(store.level_file(normal, 2), 0, Access::kUpdate); },
      [&] { store.open_session().pin(store.level_file(normal, 2), 0, Access::kOverwrite); },
      [&] { store.base_records<DerivedPoint>(normal); },
      [&] {
        visit_vertices(store, {}, std::tuple{overwrites<DerivedPoint>("normal")},
                       [](const VertexRun&, std::span<DerivedPoint> n) {
                         std::ranges::fill(n, DerivedPoint{0, 0, 1});
                       });
      },
      [&] {
        store.level_file(normal, 2).backend->write({0, 0}, {});
      }};
  for (const auto& write : writes) {
    const Error error = error_of(write);
    CHECK(error.code() == ErrorCode::kBadState);
    CHECK_THAT(error.what(), Catch::Contains("computed"));
  }
  CHECK_THAT(error_of(writes[0]).what(), Catch::Contains("--compress ATTRIBUTE=PIPELINE"));
  CHECK_THAT(error_of(writes[2]).what(), Catch::Contains("--compress normal=stored"));
  store.commit();
  CHECK(digest(store).to_string() == word);
}

TEST_CASE("Derived_RecordsOfAnotherProgram_AreNotDropped") {
  Store store = derived_in_memory(derived_torus());
  {
    const PinnedBlock pinned = store.open_session().pin(
        store.level_file(store.attribute("normal"), 2), 0, Access::kUpdate);
    pinned.bytes()[7] ^= std::byte{1};
  }
  const std::string word = digest(store).to_string();
  const Error error = error_of([&] { derive(store); });
  CHECK(error.code() == ErrorCode::kInvalidArgument);
  CHECK_THAT(error.what(), Catch::Contains("of level 2"));
  CHECK(store.attributes().size() == 2);
  CHECK(digest(store).to_string() == word);
}

TEST_CASE("Derived_AttributeWithoutItsSource_IsRefused") {
  Store store = derived_in_memory(derived_torus(2));
  derive(store);
  CHECK(error_of([&] { store.remove_attribute(store.attribute("position")); }).code() ==
        ErrorCode::kBadState);
  CHECK(error_of([&] { store.add_level(store.attribute("normal")); }).code() ==
        ErrorCode::kBadState);
  CHECK(error_of([&] { store.set_pipeline(store.attribute("normal"), "none"); }).code() ==
        ErrorCode::kBadState);
  CHECK(error_of([&] { store.set_pipeline(store.attribute("position"), "derived"); }).code() ==
        ErrorCode::kNotSupported);
  // With a finer level, its normals would be those of another surface.
  store.add_level(store.attribute("position"));
  CHECK(error_of([&] { store.commit(); }).code() == ErrorCode::kBadState);
  CHECK(error_of([&] { block_of(store, "normal", 1, 0); }).code() == ErrorCode::kBadState);
  store.add_level(store.attribute("normal"));
  CHECK_NOTHROW(block_of(store, "normal", 1, 0));
  CHECK_NOTHROW(store.commit());
  store.remove_attribute(store.attribute("normal"));
  CHECK_NOTHROW(store.remove_attribute(store.attribute("position")));
}

TEST_CASE("Derived_NormalsOfADisplacedStore_AreThoseOfTheNewPositions") {
  Store with = derived_in_memory(derived_torus()), without = derived_in_memory(derived_torus());
  derive(with);
  const DisplaceOptions how{.amplitude = 1e-2, .seed = 5};
  displace(with, how);
  displace(without, how);
  CHECK_FALSE(with.derivation(with.attribute("normal")).empty());
  CHECK(digest(with).to_string() == digest(without).to_string());
}

TEST_CASE("Derived_CopyOfAStore_IsDerivedOrStoredAsItsOptionsSay") {
  const TemporaryDirectory directory(Medium::kMemory);
  Store store = stored(directory.path() / "s.plait", derived_torus(), "pread");
  const std::string word = digest(store).to_string();
  derive(store);
  StoreOptions like = options_for("compressed");
  Store same =
      Store::create(directory.path() / "same.plait", store.base(), like, default_backends());
  copy_levels(store, same);
  same.commit();
  CHECK_FALSE(same.derivation(same.attribute("normal")).empty());
  CHECK(digest(same).to_string() == word);
  like.pipeline_of = [](const AttributeSchema& schema) {
    return schema.name == "normal" ? "normals+shuffle,zstd:1" : "hierarchy+shuffle,zstd:1";
  };
  Store back =
      Store::create(directory.path() / "back.plait", store.base(), like, default_backends());
  copy_levels(same, back);
  CHECK(back.derivation(back.attribute("normal")).empty());
  CHECK(digest(back).to_string() == word);
  // The normals of rounded positions are those of the rounded positions.
  ErrorBounds bounds;
  bounds.add("1e-4");
  like.pipeline_of = [](const AttributeSchema& schema) {
    return schema.name == "normal" ? "derived" : "shuffle,zstd:1";
  };
  Store rounded =
      Store::create(directory.path() / "rounded.plait", store.base(), like, default_backends());
  copy_levels(back, rounded, {}, bounds);
  CHECK(digest(rounded).to_string() == digest_with_new_normals(rounded));
}

TEST_CASE("Derived_ManyReadersInASmallBudget_GetTheSameBytes") {
  const TemporaryDirectory directory(Medium::kMemory);
  const fs::path path = directory.path() / "s.plait";
  const std::string backend = GENERATE(as<std::string>(), "pread", "mmap", "compressed");
  const Surface surface{BaseMesh::build(torus_grid(10, 8)), 4};
  Store expected = derived_in_memory(surface);
  {
    Store store = stored(path, surface, backend);
    recode_attribute(store, 0, backend == "compressed" ? "hierarchy+shuffle,zstd:1" : "none");
    derive(store);
    store.commit();
  }
  OpenOptions open;
  open.budget_bytes = 1 << 20;
  const Store store = Store::open(path, open, default_backends());
  const Reader reader(store), oracle(expected);
  const auto copy_of = [](const Reader& from, FaceId face, const char* name) {
    const PatchView view = from.read_patch(face, 4);
    std::vector<DerivedPoint> records(patch_vertex_count(view.size()));
    view.records(name).copy_to(std::as_writable_bytes(std::span(records)));
    return records;
  };
  std::vector<std::uint64_t> wrong(4), failed(4);
  {
    std::vector<std::jthread> threads;
    for (std::size_t worker = 0; worker < wrong.size(); ++worker)
      threads.emplace_back([&, worker] {
        for (FaceId i = 0; i < store.base().face_count(); ++i) {
          const auto face = static_cast<FaceId>((i * 37 + worker * 101) %
                                                static_cast<FaceId>(store.base().face_count()));
          try {
            const auto found = copy_of(reader, face, "normal"),
                       right = copy_of(oracle, face, "normal");
            for (std::size_t at = 0; at < found.size(); ++at)
              wrong[worker] += found[at].x != right[at].x || found[at].y != right[at].y ||
                                       found[at].z != right[at].z
                                   ? 1u
                                   : 0u;
          } catch (const Error&) {
            ++failed[worker];
          }
        }
      });
  }
  CHECK(wrong == std::vector<std::uint64_t>(4, 0));
  CHECK(failed == std::vector<std::uint64_t>(4, 0));
  CHECK(reader.statistics().peak_frame_bytes <= open.budget_bytes);
}

TEST_CASE("Derived_BudgetWithoutRoom_IsANamedErrorAndTheStoreGoesOn") {
  const TemporaryDirectory directory(Medium::kMemory);
  const fs::path path = directory.path() / "s.plait";
  Surface surface = derived_torus(5);
  {
    Store store = stored(path, surface, "pread");
    derive(store);
    store.commit();
  }
  OpenOptions open;
  open.budget_bytes = 64 << 10;
  const Store store = Store::open(path, open, default_backends());
  const LevelFile& positions = store.level_file(0, 5);
  Session session = store.open_session();
  {
    std::vector<PinnedBlock> pinned;
    try {
      for (std::uint64_t block = 0;; ++block) pinned.push_back(session.pin(positions, block));
    } catch (const Error& error) {
      REQUIRE(error.code() == ErrorCode::kBudget);
    }
    pinned.pop_back();
    const Error error = error_of([&] { block_of(store, "normal", 5, 0); });
    CHECK(error.code() == ErrorCode::kBudget);
  }
  CHECK_NOTHROW(session.pin(positions, 0));
}

TEST_CASE("Derived_ProgramWithoutTheRule_RefusesTheStore") {
  const TemporaryDirectory directory(Medium::kMemory);
  const fs::path path = directory.path() / "s.plait";
  Store store = stored(path, derived_torus(2), "pread");
  CHECK(read_manifest(Directory(path)).required_features == 0);
  derive(store);
  store.commit();
  CHECK(read_manifest(Directory(path)).required_features == kDerivedAttributes);
  store.close();
  BackendRegistry without = default_backends();
  without.set_derivations(nullptr);
  const Error error = error_of([&] { Store::open(path, {}, without); });
  CHECK(error.code() == ErrorCode::kNotSupported);
  CHECK_THAT(error.what(), Catch::Contains("'normal' is derived"));
}

TEST_CASE("Derived_HostileDerivation_IsRefusedWhenTheStoreIsOpened") {
  const std::pair<std::string, ErrorCode> cases[] = {
      {"derived", ErrorCode::kNotSupported},
      {"derived:", ErrorCode::kNotSupported},
      {"derived:normals", ErrorCode::kNotSupported},
      {"derived:normals/", ErrorCode::kNotSupported},
      {"derived:other/position", ErrorCode::kNotSupported},
      {"derived:normals/normal", ErrorCode::kNotSupported},
      {"derived:normals/nothing", ErrorCode::kCorruption},
      {"derived:normals/part", ErrorCode::kCorruption},      // no positions
      {"derived:normals/shallow", ErrorCode::kCorruption},   // fewer levels
      {"derived:normals/computed", ErrorCode::kCorruption},  // derived itself
      {"derived:" + std::string(60000, 'x'), ErrorCode::kNotSupported}};
  const TemporaryDirectory directory(Medium::kMemory);
  const fs::path path = directory.path() / "s.plait", victim = directory.path() / "v.plait";
  {
    Store store = stored(path, derived_torus(2), "pread");
    derive(store);
    store.add_attribute(schema_of<std::uint32_t>("part"), 2);
    store.add_attribute(schema_of<DerivedPoint>("shallow"), 1);
    const AttributeId computed = store.add_attribute(schema_of<DerivedPoint>("computed"));
    store.set_pipeline(computed, "derived:normals/position");
    while (store.attributes()[computed].finest_level < 2) store.add_level(computed);
    store.commit();
  }
  for (const auto& [pipeline, code] : cases) {
    CAPTURE(pipeline.substr(0, 40));
    fs::remove_all(victim);
    fs::copy(path, victim);
    forge_description(victim, [&, text = pipeline](VersionDescription& version) {
      AttributeRecord& normal = *std::ranges::find_if(
          version.attributes,
          [](const AttributeRecord& each) { return each.schema.name == "normal"; });
      normal.pipeline = text;
      for (LevelRecord& level : normal.levels) level.pipeline = text;
    });
    const Error error = error_of([&] { Store::open(victim, {}, default_backends()); });
    CHECK(error.code() == code);
    CHECK_THAT(error.what(), Catch::Contains(victim.string()));
  }
  // Only a part of the levels.
  fs::remove_all(victim);
  fs::copy(path, victim);
  forge_description(victim, [](VersionDescription& version) {
    version.attributes[0].levels[0].pipeline = "derived:normals/position";
  });
  CHECK(error_of([&] { Store::open(victim, {}, default_backends()); }).code() ==
        ErrorCode::kCorruption);
}

}  // namespace plait::test::derived_test
