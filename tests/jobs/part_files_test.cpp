// The files of parts: all levels of an attribute are in one, with each backend; stores whose shards
// have a file for each level stay as they are.
#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "format/manifest.h"
#include "pass_surfaces.h"
#include "plait/extend/directory.h"
#include "plait/extend/store_access.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"

namespace plait::test::part_files {
namespace {

using namespace plait::test::passes;

/// With a backend of the same name and files that shares no file.
BackendRegistry without_shared_files() {
  BackendRegistry backends;
  for (const std::string& name : default_backends().names()) {
    RegisteredBackend backend = default_backends().find(name);
    backend.traits.shares_files = false;
    backends.add(std::move(backend));
  }
  backends.set_chooser(default_backends().chooser());
  return backends;
}

std::vector<std::string> names_in(const fs::path& directory, const std::string& end) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(directory))
    if (std::string name = entry.path().filename(); name.ends_with(end))
      names.push_back(std::move(name));
  std::ranges::sort(names);
  return names;
}

std::size_t count_files(const fs::path& directory) { return names_in(directory, "").size(); }

PartsRequest request_of(const Surfaces& on, const std::string& backend) {
  PartsRequest request{.mesh = on.mesh,
                       .plan = on.directory / "shards",
                       .parts = 4,
                       .levels = on.levels,
                       .normals = true,
                       .block_bytes = 4 << 10,
                       .max_slot_bytes = on.max_slot_bytes};
  if (backend == "compressed")
    request.pipeline_of = [](const AttributeSchema&) { return LevelPipelines("shuffle,zstd:1"); };
  return request;
}

void make_store(const Surfaces& on, const std::string& backend, const BackendRegistry& backends) {
  const PartsRequest request = request_of(on, backend);
  const PartsPlan plan = plan_parts(request, backends);
  for (std::uint32_t part = 0; part < request.parts; ++part)
    make_part(request.plan, part, {}, backends);
  REQUIRE(join_parts(request.plan, on.sharded(), {.verify = true}, backends).has_store);
  CHECK(count_files(on.sharded()) == plan.files);
  fs::remove_all(request.plan);
}

std::uint32_t required_features_of(const fs::path& store) {
  return read_manifest(Directory(store)).required_features;
}

}  // namespace

TEST_CASE("Parts_OfEachBackend_HaveOneFileForAllLevels") {
  std::string expected;
  for (const std::string backend : {"pread", "compressed"}) {
    CAPTURE(backend);
    const TemporaryDirectory here(Medium::kMemory);
    const Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
    make_store(on, backend, default_backends());
    CHECK(names_in(on.sharded(), ".shard2") ==
          std::vector<std::string>{"attribute0.levels.1.shard2", "attribute1.levels.1.shard2",
                                   "version.1.shard2"});
    CHECK((required_features_of(on.sharded()) & kSharedFiles) != 0);
    const std::string found = digest_of(on.sharded());
    if (expected.empty()) expected = found;
    CHECK(found == expected);
    const StoreCheck check = check_store(on.sharded(), default_backends());
    CHECK(check.damaged.empty());
    CHECK(check.left_over.empty());
    // The bytes of the levels are those of their files.
    std::uint64_t in_files = 0, in_levels = 0;
    for (const std::string& name : names_in(on.sharded(), ""))
      if (name.find(".levels.") != std::string::npos)
        in_files += fs::file_size(on.sharded() / name);
    const Store store = Store::open(on.sharded(), {}, default_backends());
    for (AttributeId id = 0; id < store.attributes().size(); ++id)
      for (int level = store.base_level() + 1; level <= store.finest_level(); ++level)
        in_levels += StoreAccess::level_file(store, id, level).backend->stored_bytes();
    if (backend == "compressed") {
      CHECK(in_levels < in_files + 8 * 512);
      CHECK(in_levels >= in_files);
    } else {
      CHECK(in_levels == in_files);
    }
  }
  CHECK(!expected.empty());
}

TEST_CASE("ShardedStore_WithAFileForEachLevel_StaysAsItIs") {
  const TemporaryDirectory here(Medium::kMemory);
  const Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  const BackendRegistry old = without_shared_files();
  make_store(on, "pread", old);
  CHECK((required_features_of(on.sharded()) &
         (std::uint32_t{RequiredFeature::kShards} | kSharedFiles)) ==
        std::uint32_t{RequiredFeature::kShards});
  const int levels = on.levels - Store::open(on.sharded(), {}, default_backends()).base_level();
  REQUIRE(levels > 1);
  CHECK(names_in(on.sharded(), ".shard1").size() == static_cast<std::size_t>(2 * levels + 1));
  const std::string before = digest_of(on.sharded());
  CHECK(check_store(on.sharded(), default_backends()).damaged.empty());
  CHECK(check_store(on.sharded(), default_backends()).left_over.empty());

  // A damaged shard is mended by a part with the same files.
  const fs::path level = on.sharded() / "attribute0.level03.1.shard1";
  damage_own(level, 3);
  plan_again(on.sharded(), on.directory / "again", default_backends());
  make_part(on.directory / "again", 1, {}, default_backends());
  CHECK(join(on.directory / "again", on.sharded()).was_joined);
  CHECK(digest_of(on.sharded()) == before);

  // A pass makes such files too, and those of the version before go.
  pass_in_parts(on, kSmooth);
  CHECK(names_in(on.sharded(), ".shard1").size() == static_cast<std::size_t>(2 * levels + 1));
  CHECK(fs::exists(on.sharded() / "attribute2.level03.2.shard1"));
  CHECK((required_features_of(on.sharded()) & kSharedFiles) == 0);
  CHECK(check_store(on.sharded(), default_backends()).damaged.empty());
  CHECK(check_store(on.sharded(), default_backends()).left_over.empty());
}

TEST_CASE("ShardedStore_OfCompressedBlocks_IsMendedByAPartThatHasThemInAnotherOrder", "[threads]") {
  const TemporaryDirectory here(Medium::kMemory);
  const Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  make_store(on, "compressed", default_backends());
  const std::string before = digest_of(on.sharded());
  const fs::path file = on.sharded() / "attribute0.levels.1.shard1",
                 other = on.sharded() / "attribute1.levels.1.shard1";
  const std::string whole = content_of(file), whole_other = content_of(other);
  const fs::path plan = here.path() / "again";
  plan_again(on.sharded(), plan, default_backends());
  const auto damage = [&] { damage_own(file, 1); };
  // Blocks come in the order in which threads have them; mostly that is another one at once.
  bool is_other_order = false;
  const auto make_in_other_order = [&] {
    is_other_order = false;
    for (int attempt = 0; attempt < 30 && !is_other_order; ++attempt) {
      make_part(plan, 1, {.threads = 3, .again = true}, default_backends());
      is_other_order = content_of(directory_of(plan, 1) / file.filename()) != whole;
    }
  };
  const auto join_and_count = [&] {
    std::vector<std::string> warnings;
    const JoinOptions how{.warn = [&](const std::string& warning) { warnings.push_back(warning); }};
    CHECK(join(plan, on.sharded(), how).was_joined);
    return warnings.size();
  };
  damage();
  make_in_other_order();
  CAPTURE(is_other_order);
  CHECK(join_and_count() == 1);
  CHECK((content_of(file) == whole));
  CHECK((content_of(other) == whole_other));
  CHECK(digest_of(on.sharded()) == before);
  CHECK(join_and_count() == 0);  // nothing is left to mend
  pass_in_parts(on, {.name = "normals"});
  damage();
  fs::remove_all(plan);
  plan_again(on.sharded(), plan, default_backends());
  make_in_other_order();
  CHECK(join_and_count() == 1);
  CHECK((content_of(file) == whole));
  CHECK(check_store(on.sharded(), default_backends()).damaged.empty());
  CHECK(check_store(on.sharded(), default_backends()).left_over.empty());
}

TEST_CASE("ShardedStore_SharedFileCut_NamesItAndTheLevelsBehindTheCut") {
  const TemporaryDirectory here(Medium::kMemory);
  const Surfaces on = surfaces_of(here.path(), random_sheet(5, 60));
  make_store(on, "pread", default_backends());
  const std::uint64_t files = check_store(on.sharded(), default_backends()).files;
  const fs::path file = on.sharded() / "attribute1.levels.1.shard2";
  fs::resize_file(file, fs::file_size(file) - 1);
  const StoreCheck check = check_store(on.sharded(), default_backends());
  CHECK(check.files == files);
  CHECK(files <= count_files(on.sharded()));  // one that has several levels counts once
  REQUIRE(check.damaged.size() == 1);
  CHECK(check.damaged[0].name == file.filename());
  CHECK(check.damaged[0].level == on.levels);
  CHECK(error_of([&] { digest_of(on.sharded()); }).code() == ErrorCode::kCorruption);
}

}  // namespace plait::test::part_files
