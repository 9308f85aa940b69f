// A store that many processes make in parts: the same records, digests and bytes as one process
// makes; what is missing, damaged or foreign is named by its number.
#include "plait/extend/parts.h"

#include <sys/stat.h>

#include <array>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <initializer_list>
#include <iterator>
#include <map>
#include <set>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "engine/store/forge.h"
#include "format/checksum.h"
#include "format/manifest.h"
#include "format/version_description.h"
#include "format/version_file.h"
#include "jobs/pass_surfaces.h"
#include "parts/done_file.h"
#include "parts/plan_file.h"
#include "plait/compression.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/extend/check_store.h"
#include "plait/extend/store_access.h"
#include "plait/reader.h"
#include "plait/registry.h"
#include "plait/subdivision_job.h"
#include "plait/verify.h"
#include "support/answering_operations.h"
#include "support/before_operation.h"
#include "support/error_of.h"
#include "support/file_bytes.h"
#include "support/sanitized.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test::parts {
namespace {

using namespace plait::test::passes;
using Numbers = std::vector<std::uint32_t>;

/// A surface in a directory of its own: a small sheet, with normals.
struct Work : Surfaces {
  TemporaryDirectory here{Medium::kMemory};
  fs::path plan = here.path() / "plan", path = here.path() / "s.plait";

  explicit Work(const IndexedMesh& surface = random_sheet(5, 60)) {
    directory = here.path();
    mesh = directory / "mesh.ply";
    normals = true;
    write_ply(mesh, surface);
  }
  PartsPlan make_plan(std::uint32_t parts) const {
    return plan_parts(request(parts, "plan"), default_backends());
  }
};

void make_all(const fs::path& plan, std::uint32_t parts, int threads = 1) {
  for (std::uint32_t part = 0; part < parts; ++part)
    make_part(plan, part, {.threads = threads}, default_backends());
}

/// A plan of the sheet whose parts are all made.
struct Made : Work {
  explicit Made(std::uint32_t parts) {
    make_plan(parts);
    make_all(plan, parts);
  }
};

/// One read of all blocks of a level crosses all cuts.
void check_range_of_blocks(const Store& sharded, const Store& whole) {
  const AttributeId position = sharded.attribute("position");
  const auto bytes = [&](const Store& store) {
    const LevelFile& level = StoreAccess::level_file(store, position, store.finest_level());
    std::vector<std::byte> all(level.geometry.total_bytes());
    level.backend->read({0, level.geometry.block_count()}, all);
    return all;
  };
  CHECK(bytes(sharded) == bytes(whole));
}

void check_parts(const Work& work, std::uint32_t parts, const std::string& expected,
                 const std::map<std::string, std::string>& files) {
  CAPTURE(parts);
  work.make_plan(parts);
  make_all(work.plan, parts, parts % 2 == 0 ? 2 : 1);
  const JoinResult joined = join(work.plan, work.path, {.verify = true});
  REQUIRE(joined.has_store);
  CHECK(joined.digest == expected);
  const fs::path one = work.directory / "one.plait";
  {
    const Store opened = Store::open(work.path, {}, default_backends());
    CHECK(digest(opened).to_string() == expected);
    const StoreCheck check = check_store(work.path, default_backends());
    CHECK(check.damaged.empty());
    CHECK(check.left_over.empty());
    REQUIRE(join(work.plan, one, {.concat = true}).has_store);
    check_by_format(work.path, one);
    check_range_of_blocks(opened, Store::open(one, {}, default_backends()));
  }
  CHECK(record_files(one) == files);
  for (const fs::path& made : {work.plan, work.path, one}) fs::remove_all(made);
}

void check_work(const Work& work, const Numbers& numbers) {
  const std::string expected = work.make_whole();
  const auto files = record_files(work.whole());
  for (const std::uint32_t parts : numbers) check_parts(work, parts, expected, files);
  fs::remove_all(work.whole());
}

JoinResult refused_join(const fs::path& directory, const fs::path& plan) {
  JoinResult joined = join(plan, directory / "refused.plait");
  CHECK_FALSE(joined.has_store);
  CHECK_FALSE(fs::exists(directory / "refused.plait"));
  REQUIRE(joined.reasons.size() == joined.bad.size());
  return joined;
}

Numbers wrong_parts(const fs::path& directory, const fs::path& plan) {
  return refused_join(directory, plan).bad;
}

/// Replaces bytes of a file of a plan by as many others, and makes its checksum right.
void forge(const fs::path& path, const std::string& from, const std::string& to) {
  std::string bytes = content_of(path);
  const std::size_t at = bytes.find(from);
  REQUIRE(at != std::string::npos);
  REQUIRE(from.size() == to.size());
  bytes.replace(at, from.size(), to);
  std::uint64_t checksum = 0;
  const std::size_t end = bytes.size() - sizeof checksum;
  checksum = checksum_of(std::as_bytes(std::span(bytes)).first(end));
  bytes.replace(end, sizeof checksum, reinterpret_cast<const char*>(&checksum), sizeof checksum);
  write_content(path, bytes);
}

}  // namespace

TEST_CASE("Parts_OfAnyNumber_GiveTheRecordsOfOneProcess", "[threads]") {
  Work work;
  SECTION("Loop with normals, a mesh with border") {
    check_work(work, unless_sanitized(Numbers{1, 2, 3, 7, 16, 64}, Numbers{2, 7}));
  }
  SECTION("limit positions") {
    work.limit = true;
    work.normals = false;
    check_work(work, unless_sanitized(Numbers{3, 16}, Numbers{3}));
  }
  SECTION("Butterfly") {
    work.scheme = scheme_from_name("butterfly");
    check_work(work, unless_sanitized(Numbers{2, 7}, Numbers{2}));
  }
  SECTION("Midpoint, without refinement of the base mesh") {
    work.scheme = scheme_from_name("midpoint");
    work.max_slot_bytes = std::nullopt;
    check_work(work, unless_sanitized(Numbers{2, 7}, Numbers{2}));
  }
  SECTION("a closed mesh") {
    write_ply(work.mesh, random_sphere(3, 80));
    check_work(work, unless_sanitized(Numbers{3, 64}, Numbers{16}));
  }
}

TEST_CASE("Parts_OfALargeBaseMesh_TakeItReadyFromThePlan") {
  Work work(torus_grid(128, 64));
  work.levels = 2;
  work.max_slot_bytes = std::nullopt;
  const std::string expected = work.make_whole();
  const fs::path& plan = work.plan;
  work.make_plan(3);
  const std::string index = content_of(plan / "base.index");
  CHECK_FALSE(index.empty());
  CHECK(index == content_of(work.whole() / "base.index"));
  std::string damaged = index;
  damaged[damaged.size() / 2] ^= 1;
  write_content(plan / "base.index", damaged);
  const Error error = error_of([&] { make_part(plan, 0, {}, default_backends()); });
  CHECK(error.code() == ErrorCode::kCorruption);
  CHECK(std::string(error.what()).find("base.index") != std::string::npos);
  fs::remove(plan / "base.index");
  make_part(plan, 0, {}, default_backends());
  write_content(plan / "base.index", index);
  make_all(plan, 3);
  CHECK(join(plan, work.path).digest == expected);
  CHECK(content_of(work.path / "base.index") == index);
  CHECK(digest_of(work.path) == expected);
  CHECK(check_store(work.path, default_backends()).damaged.empty());
  format::read_store(work.path);
}

TEST_CASE("Part_OfALargeBaseMesh_ReadsWhatItsEdgesNeed") {
  Work work(torus_grid(400, 250));
  work.levels = 1;
  work.max_slot_bytes = std::nullopt;
  const fs::path& plan = work.plan;
  constexpr std::uint32_t kParts = 16;
  work.make_plan(kParts);
  const std::string index = content_of(plan / "base.index");
  // Every seventh page is damaged in turn; a part stumbles over the few that it reads, and is right
  // otherwise.
  std::map<std::uint32_t, std::string> digests;
  for (const std::uint32_t part : {0u, kParts - 1})
    digests[part] = make_part(plan, part, {}, default_backends()).digest;
  std::size_t refused = 0, made = 0;
  for (std::size_t at = index.size() - 7; at > (448u << 10); at -= 448u << 10) {
    std::string damaged = index;
    damaged[at] ^= 1;
    write_content(plan / "base.index", damaged);
    for (const auto& [part, digest] : digests) {
      CAPTURE(at, part);
      try {
        const std::string found = make_part(plan, part, {.again = true}, default_backends()).digest;
        CHECK(found == digest);
        ++made;
      } catch (const Error& error) {
        CHECK(error.code() == ErrorCode::kCorruption);
        CHECK(std::string(error.what()).find("base.index") != std::string::npos);
        ++refused;
      }
    }
  }
  CHECK(refused > 4);
  CHECK(made > 2 * refused);
}

TEST_CASE("Parts_MoreThanAreOpenAtOnce_GiveTheRecordsOfOneProcess", "[threads]") {
  Work work(random_sheet(9, unless_sanitized(900u, 300u)));
  work.levels = 2;
  work.normals = false;
  work.max_slot_bytes = std::nullopt;
  check_work(work, {unless_sanitized(200u, 70u)});
}

TEST_CASE("Parts_Compressed_GiveTheRecordsOfOneProcess") {
  const Work work;
  const std::string expected = work.make_whole();
  PartsRequest request = work.request(7, "plan");
  const auto use = [&](const std::string& preset) {
    request.pipeline_of = [preset](const AttributeSchema& schema) {
      return LevelPipelines(preset_pipeline(preset, schema));
    };
  };
  use("fast");
  plan_parts(request, default_backends());
  make_all(request.plan, 7);
  REQUIRE(join(request.plan, work.path, {.verify = true}).has_store);
  CHECK(digest_of(work.path) == expected);
  request.plan = work.directory / "refused";
  use("small");
  CHECK(error_of([&] { plan_parts(request, default_backends()); }).code() ==
        ErrorCode::kNotSupported);
  CHECK_FALSE(fs::exists(request.plan));
}

TEST_CASE("Plan_BlockSizeThatNoStoreHas_IsRefusedBeforeAnyPartIsMade") {
  const Work work;
  PartsRequest request = work.request(2, "plan");
  for (const std::uint64_t bytes : {1u, 2048u, 5000u, 1u << 31}) {
    request.block_bytes = bytes;
    CAPTURE(bytes);
    CHECK(error_of([&] { plan_parts(request, default_backends()); }).code() ==
          ErrorCode::kInvalidArgument);
    CHECK_FALSE(fs::exists(request.plan));
  }
}

TEST_CASE("Part_MadeTwiceOrByTwoAtOnce_IsMadeOnce", "[threads]") {
  const Work work;
  const fs::path& plan = work.plan;
  work.make_plan(2);
  const PartResult first = make_part(plan, 0, {}, default_backends());
  CHECK_FALSE(first.was_done);
  const PartResult second = make_part(plan, 0, {}, default_backends());
  CHECK(second.was_done);
  CHECK(second.digest == first.digest);
  const PartResult third = make_part(plan, 0, {.again = true}, default_backends());
  CHECK_FALSE(third.was_done);
  CHECK(third.digest == first.digest);
  {
    std::array<std::jthread, 4> racing;
    for (std::jthread& one : racing)
      one = std::jthread([&] { make_part(plan, 1, {}, default_backends()); });
  }
  CHECK(join(plan, work.path).digest == work.make_whole());
  std::size_t directories = 0;
  for (const auto& entry : fs::directory_iterator(plan)) directories += entry.is_directory();
  CHECK(directories == 2);
}

TEST_CASE("Join_PartsMissingOrWrong_NamesThemByNumber") {
  const Work work;
  const fs::path& plan = work.plan;
  const fs::path other = work.directory / "other";
  constexpr std::uint32_t kParts = 6;
  work.make_plan(kParts);
  for (const std::uint32_t part : {0u, 2u}) make_part(plan, part, {}, default_backends());
  const JoinResult missing = join(plan, work.path);
  CHECK(missing.missing == Numbers{1, 3, 4, 5});
  CHECK(missing.again() == "1,3-5");
  make_all(plan, kParts);
  SECTION("a file of a level is cut") {
    const fs::path file = directory_of(plan, 3) / "attribute0.levels.1.shard3";
    fs::resize_file(file, fs::file_size(file) - 1);
    CHECK(wrong_parts(work.directory, plan) == Numbers{3});
    CHECK_FALSE(make_part(plan, 3, {}, default_backends()).was_done);
    CHECK(join(plan, work.path).has_store);
  }
  SECTION("a file of a level, the tables or done.I are missing") {
    fs::remove(directory_of(plan, 2) / "attribute1.levels.1.shard2");
    fs::remove(directory_of(plan, 4) / "version.1.shard4");
    fs::remove(plan / "done.5");
    CHECK(wrong_parts(work.directory, plan) == Numbers{2, 4});
    CHECK(join(plan, work.path).again() == "2,4-5");
  }
  SECTION("done.I is cut") {
    fs::resize_file(plan / "done.1", fs::file_size(plan / "done.1") - 1);
    CHECK(wrong_parts(work.directory, plan) == Numbers{1});
  }
  SECTION("two parts are exchanged") {
    fs::rename(plan / "done.1", plan / "x");
    fs::rename(plan / "done.2", plan / "done.1");
    fs::rename(plan / "x", plan / "done.2");
    const JoinResult joined = refused_join(work.directory, plan);
    REQUIRE(joined.bad == Numbers{1, 2});
    CHECK_THAT(joined.reasons[0], Catch::Contains("expected part 1, found part 2"));
  }
  SECTION("the directories of two parts are exchanged") {
    const fs::path a = directory_of(plan, 1), b = directory_of(plan, 2);
    fs::rename(a, plan / "x");
    fs::rename(b, a);
    fs::rename(plan / "x", b);
    CHECK(wrong_parts(work.directory, plan) == Numbers{1, 2});
  }
  SECTION("a part is of another plan") {
    work.plan_shards(kParts, "other");
    make_part(other, 4, {}, default_backends());
    fs::copy_file(other / "done.4", plan / "done.4", fs::copy_options::overwrite_existing);
    fs::copy(directory_of(other, 4), plan / directory_of(other, 4).filename());
    CHECK(wrong_parts(work.directory, plan) == Numbers{4});
  }
  SECTION("done.I names a directory that is not a part's") {
    const Directory directory = open_plan_directory(plan);
    const PlanFile file = read_plan_file(directory);
    DoneFile done = *read_done_part(directory, file, 1);
    fs::copy(directory_of(plan, 1), work.directory);
    done.directory = "..";
    const std::vector<std::byte> bytes = encode_done_file(file, done);
    std::ofstream(plan / "done.1", std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    CHECK(wrong_parts(work.directory, plan) == Numbers{1});
    make_part(plan, 1, {.again = true}, default_backends());
    CHECK(fs::exists(work.directory / "version.1.shard1"));
    CHECK(join(plan, work.path).has_store);
  }
  SECTION("links and FIFOs are no files of a part") {
    const auto replace_by_link = [&](const fs::path& path) {
      const fs::path moved = work.directory / ("moved" + path.filename().native());
      fs::rename(path, moved);
      fs::create_symlink(moved, path);
    };
    replace_by_link(plan / "done.0");
    replace_by_link(directory_of(plan, 1));
    replace_by_link(directory_of(plan, 2) / "records");
    replace_by_link(directory_of(plan, 3) / "attribute0.levels.1.shard3");
    const fs::path fifo = directory_of(plan, 4) / "version.1.shard4";
    fs::remove(fifo);
    REQUIRE(::mkfifo(fifo.c_str(), 0600) == 0);
    fs::remove(plan / "done.5");
    REQUIRE(::mkfifo((plan / "done.5").c_str(), 0600) == 0);
    CHECK(wrong_parts(work.directory, plan) == Numbers{0, 1, 2, 3, 4, 5});
    make_all(plan, kParts);
    CHECK(join(plan, work.path).has_store);
  }
  SECTION("a file of zeros takes no time, whatever its size") {
    fs::resize_file(directory_of(plan, 1) / "records", std::uintmax_t{1} << 42);
    fs::resize_file(directory_of(plan, 2) / "version.1.shard2", std::uintmax_t{1} << 42);
    fs::resize_file(plan / "done.3", std::uintmax_t{1} << 42);
    const JoinResult joined = refused_join(work.directory, plan);
    REQUIRE(joined.bad == Numbers{1, 2, 3});
    CHECK_THAT(joined.reasons[0], Catch::Contains("records: expected at most"));
    CHECK_THAT(joined.reasons[1], Catch::Contains("version.1.shard2: expected at most"));
    fs::resize_file(plan / "base.mesh", std::uintmax_t{1} << 42);
    for (const auto& call : std::initializer_list<std::function<void()>>{
             [&] { join(plan, work.path); }, [&] { make_part(plan, 1, {}, default_backends()); }}) {
      const Error error = error_of(call);
      CHECK(error.code() == ErrorCode::kCorruption);
      CHECK_THAT(error.what(), Catch::Contains("hole"));
    }
  }
  SECTION("done.I says what no part of the plan has, with the right checksum") {
    forge(plan / "done.0", "part.0-", "part.1-");  // the directory of another part
    forge(plan / "done.1", "attribute0.levels.1.shard1", "attribute0.levels.1.shard2");
    forge(plan / "done.2", "attribute1.levels.1.shard2", "attribute0.levels.1.shard2");  // twice
    forge(plan / "done.3", "part.3-", "part.3/");
    forge(plan / "done.4", "normal", "normaL");  // another description than the others have
    const JoinResult joined = refused_join(work.directory, plan);
    REQUIRE(joined.bad == Numbers{0, 1, 2, 3, 4});
    for (const std::size_t part : {0u, 3u})
      CHECK_THAT(joined.reasons[part], Catch::Contains("the directory is part."));
    for (const std::size_t part : {1u, 2u})
      CHECK_THAT(joined.reasons[part], Catch::Contains("a file is attribute0."));
  }
  SECTION("the plan is another one with the same UUID") {
    const std::string bytes = content_of(plan / "plan");
    const std::string seconds =
        bytes.substr(bytes.size() - 16, 8);  // of the last part, not in done.I
    forge(plan / "plan", seconds, std::string(8, '\1'));
    const JoinResult joined = refused_join(work.directory, plan);
    REQUIRE(joined.bad == Numbers{0, 1, 2, 3, 4, 5});
    CHECK_THAT(joined.reasons[0], Catch::Contains("of another plan"));
  }
  SECTION("a block is damaged, which only --verify reads") {
    flip_byte(directory_of(plan, 5) / "attribute0.levels.1.shard5", 40);
    const JoinOptions options{.verify = true};
    const JoinResult joined = join(plan, work.path, options);
    CHECK(joined.bad == Numbers{5});
    CHECK_FALSE(fs::exists(work.path));
    SECTION("while other parts are missing or bad") {
      fs::remove(plan / "done.2");
      forge(plan / "done.3", "part.3-", "part.3/");
      const JoinResult early = join(plan, work.path, options);
      CHECK(early.missing == Numbers{2});
      REQUIRE(early.bad == Numbers{3, 5});
      CHECK_THAT(early.reasons[0], Catch::Contains("the directory is part."));
      CHECK_THAT(early.reasons[1], Catch::Contains("attribute0.levels.1.shard5"));
    }
  }
  SECTION("the base mesh is another one") {
    flip_byte(plan / "base.mesh",
              static_cast<std::streamoff>(fs::file_size(plan / "base.mesh")) - 1);
    CHECK(error_of([&] { join(plan, work.path); }).code() == ErrorCode::kCorruption);
    CHECK(error_of([&] { make_part(plan, 0, {.again = true}, default_backends()); }).code() ==
          ErrorCode::kCorruption);
  }
}

TEST_CASE("Join_RunAgain_FindsItsStoreAndChangesNothing") {
  const Made work(5);
  const fs::path &plan = work.plan, &path = work.path;
  const JoinResult first = join(plan, path);
  REQUIRE(first.has_store);
  CHECK_FALSE(first.was_joined);
  const auto written = fs::last_write_time(path);
  const JoinOptions verify{.verify = true};
  for (const JoinOptions& options : {JoinOptions(), verify}) {
    const JoinResult again = join(plan, path, options);
    CHECK(again.has_store);
    CHECK(again.was_joined);
    CHECK(again.digest == first.digest);
  }
  CHECK(fs::last_write_time(path) == written);
  SECTION("a block of the store is damaged, which only --verify reads") {
    damage_own(path / "attribute0.levels.1.shard4", 40);
    CHECK(join(plan, path).was_joined);
    const Error error = error_of([&] { join(plan, path, verify); });
    CHECK(error.code() == ErrorCode::kCorruption);
    CHECK_THAT(error.what(), Catch::Contains("position at level 2"));
  }
  SECTION("the name belongs to another store, or to none") {
    const fs::path other = work.directory / "other";
    work.plan_shards(5, "other");
    make_all(other, 5);
    CHECK(error_of([&] { join(other, path); }).code() == ErrorCode::kInvalidArgument);
    fs::create_directory(work.directory / "none");
    std::ofstream(work.directory / "none" / "notes") << "mine";
    CHECK(error_of([&] { join(plan, work.directory / "none"); }).code() ==
          ErrorCode::kInvalidArgument);
  }
  SECTION("--force makes it anew") {
    CHECK_FALSE(join(plan, path, {.existing = Existing::kReplace}).was_joined);
  }
}

// As many threads as the budget has scratch memory for; the records are the same.
TEST_CASE("Part_MoreThreadsThanTheBudgetAllows_TakesFewerAndSaysSo", "[threads]") {
  Work work;
  work.levels = 6;
  work.max_slot_bytes = std::nullopt;
  const fs::path& plan = work.plan;
  const PartsPlan planned = work.make_plan(2);
  REQUIRE(planned.memory);
  CHECK(planned.memory->budget_bytes == StoreOptions().budget_bytes);
  CHECK(planned.memory->total_bytes > planned.memory->budget_bytes);
  std::vector<std::string> warnings;
  PartOptions options{.budget_bytes = 8 << 20,
                      .threads = 64,
                      .warn = [&](const std::string& warning) { warnings.push_back(warning); }};
  const std::string few = make_part(plan, 1, options, default_backends()).digest;
  REQUIRE(!warnings.empty());
  CHECK_THAT(warnings[0], Catch::Contains("threads of 64") && Catch::Contains("--memory"));
  options.again = true;
  options.threads = 2;
  options.budget_bytes = StoreOptions().budget_bytes;
  warnings.clear();
  CHECK(make_part(plan, 1, options, default_backends()).digest == few);
  CHECK(warnings.empty());
}

TEST_CASE("Join_InOnePieceRunAgain_FindsItsStore") {
  const Made work(3);
  const fs::path &plan = work.plan, &path = work.path;
  const fs::path shards = work.directory / "shards.plait", other = work.directory / "other";
  JoinOptions concat{.concat = true};
  const JoinResult first = join(plan, path, concat);
  CHECK_FALSE(first.was_joined);
  for (const bool verify : {false, true}) {
    concat.verify = verify;
    const JoinResult again = join(plan, path, concat);
    CHECK(again.was_joined);
    CHECK(again.digest == first.digest);
  }
  concat.verify = false;
  // What is in shards is not what --concat asks for, nor the other way round.
  REQUIRE(join(plan, shards).has_store);
  CHECK(error_of([&] { join(plan, shards, concat); }).code() == ErrorCode::kInvalidArgument);
  CHECK(error_of([&] { join(plan, path); }).code() == ErrorCode::kInvalidArgument);
  work.plan_shards(3, "other");
  make_all(other, 3);
  CHECK(error_of([&] { join(other, path, concat); }).code() == ErrorCode::kInvalidArgument);
}

/// The directory in which a join makes its store.
fs::path unfinished_in(const fs::path& directory) {
  for (const auto& entry : fs::directory_iterator(directory))
    if (entry.path().native().find(".partial-") != std::string::npos) return entry.path();
  return {};
}

TEST_CASE("Join_BesideAPartThatIsMadeAgain_ReadsItAgain") {
  const Made work(4);
  const fs::path &plan = work.plan, &path = work.path;
  const std::string digest = work.make_whole();
  using Kind = FileOperation::Kind;
  for (const Kind kind : {Kind::kOpen, Kind::kCreate})
    for (const bool verify : {false, true}) {
      CAPTURE(kind == Kind::kOpen, verify);
      const BeforeOperation again(kind, "attribute0.levels.1.shard2",
                                  [&] { make_part(plan, 2, {.again = true}, default_backends()); });
      const JoinResult joined = join(plan, path, {.verify = verify});
      CHECK(again.was_done());
      CHECK(joined.has_store);
      CHECK(joined.bad.empty());
      CHECK(joined.digest == digest);
      CHECK(check_store(path, default_backends()).damaged.empty());
      fs::remove_all(path);
    }
}

TEST_CASE("PlanAgain_OfAStore_MendsAShardByOnePart") {
  const Made work(4);
  const fs::path &plan = work.plan, &path = work.path;
  const fs::path again = work.directory / "again";
  const std::string digest = join(plan, path).digest;
  const std::map<std::string, std::string> files = record_files(path);
  const std::string tables = content_of(path / "version.1.shard2");

  const PartsPlan made = plan_again(path, again, default_backends());
  CHECK(made.parts.size() == 4);
  CHECK(content_of(again / "plan") == content_of(plan / "plan"));
  fs::remove_all(plan);
  const fs::path level = path / "attribute1.levels.1.shard2";
  damage_own(level, 5);
  SECTION("a file is missing too") { CHECK(fs::remove(path / "attribute0.levels.1.shard2")); }
  SECTION("a file is cut") {
    fs::resize_file(level, fs::file_size(level) / 2);
    CHECK(fs::file_size(level) > 0);
  }
  SECTION("the tables are damaged") {
    damage_own(path / "version.1.shard2", 40);
    CHECK(content_of(path / "version.1.shard2") != tables);
  }
  make_part(again, 2, {}, default_backends());
  std::vector<std::string> warnings;
  const JoinOptions options{
      .verify = true, .warn = [&](const std::string& warning) { warnings.push_back(warning); }};
  const JoinResult mended = join(again, path, options);
  CHECK(mended.has_store);
  CHECK(mended.was_joined);
  CHECK(mended.digest == digest);
  REQUIRE(warnings.size() == 1);
  CHECK_THAT(warnings[0], Catch::Contains("shard 2") && Catch::Contains("part 2"));
  CHECK(record_files(path) == files);
  CHECK(content_of(path / "version.1.shard2") == tables);
  CHECK(check_store(path, default_backends()).damaged.empty());
  CHECK(check_store(path, default_backends()).left_over.empty());
}

TEST_CASE("PlanAgain_PartWithOtherBlocks_MendsNothing") {
  const Made work(3);
  const fs::path &plan = work.plan, &path = work.path;
  REQUIRE(join(plan, path).has_store);
  fs::remove_all(plan);
  plan_again(path, plan, default_backends());
  make_part(plan, 1, {}, default_backends());
  const fs::path level = path / "attribute0.levels.1.shard1";
  damage_own(level, 7);
  const std::string damaged = content_of(level);
  // The part is damaged too: its tables are right, its blocks are not.
  damage_own(directory_of(plan, 1) / level.filename(), 9);
  const Error error = error_of([&] { join(plan, path); });
  CHECK(error.code() == ErrorCode::kCorruption);
  CHECK(content_of(level) == damaged);
  // Readers keep the file that they have.
  make_part(plan, 1, {.again = true}, default_backends());
  {
    const Store reader = Store::open(path, {}, default_backends());
    CHECK(error_of([&] { join(plan, path); }).code() == ErrorCode::kBusy);
    CHECK(content_of(level) == damaged);
  }
  CHECK(join(plan, path).was_joined);
  CHECK(content_of(level) != damaged);
}

TEST_CASE("Join_WhoseFilesAnotherProcessRemoves_PublishesNothing") {
  const Made work(3);
  const fs::path &plan = work.plan, &path = work.path;
  for (const char* const name : {"attribute0.levels.1.shard1", "version.1.shard0", "base.mesh"}) {
    CAPTURE(name);
    const BeforeOperation remove(FileOperation::Kind::kWrite, "version.1",
                                 [&] { fs::remove(unfinished_in(work.directory) / name); });
    const Error error = error_of([&] { join(plan, path); });
    CHECK(remove.was_done());
    CHECK(error.code() == ErrorCode::kBusy);
    CHECK_THAT(error.what(), Catch::Contains(name) && !Catch::Contains("partial"));
    CHECK_FALSE(fs::exists(path));
  }
  CHECK(join(plan, path).has_store);
}

TEST_CASE("Join_BesideAnotherOneOfThePlan_TakesItsStore") {
  const Made work(3);
  const fs::path &plan = work.plan, &path = work.path;
  const BeforeOperation other(FileOperation::Kind::kWrite, "version.1",
                              [&] { CHECK_FALSE(join(plan, path).was_joined); });
  CHECK(join(plan, path).was_joined);
  CHECK(other.was_done());
  CHECK(check_store(path, default_backends()).damaged.empty());
  CHECK(std::distance(fs::directory_iterator(work.directory), {}) == 3);  // mesh, plan, store
}

TEST_CASE("Part_WhoseRenameIsDoneAndCalledMissing_Stays") {
  const Work work;
  const fs::path& plan = work.plan;
  work.make_plan(2);
  PartOptions options{.again = GENERATE(false, true)};
  if (options.again) make_part(plan, 0, {}, default_backends());
  {
    // As NFS does when the answer of a rename is lost and the client asks again.
    const AnsweringOperations lost([&](const FileOperation& operation) {
      if (operation.kind != FileOperation::Kind::kRename || operation.to == nullptr ||
          operation.to->filename() != "done.0")
        return 0;
      std::error_code ignored;
      fs::rename(operation.path, *operation.to, ignored);
      return ENOENT;
    });
    CHECK_FALSE(make_part(plan, 0, options, default_backends()).was_done);
    CHECK(lost.answers() > 0);
  }
  make_part(plan, 1, {}, default_backends());
  CHECK_FALSE(join(plan, work.path).was_joined);
  CHECK(check_store(work.path, default_backends()).damaged.empty());
  // A file that is missing indeed is an error.
  const AnsweringOperations missing(FileOperation::Kind::kRename, ENOENT);
  options.again = true;
  CHECK(error_of([&] { make_part(plan, 0, options, default_backends()); }).code() ==
        ErrorCode::kNotFound);
}

TEST_CASE("Part_ItsFiles_AreTheOnlyOnesItChanges") {
  const Work work;
  const fs::path& plan = work.plan;
  work.make_plan(3);
  make_part(plan, 0, {}, default_backends());
  check_that_a_part_changes_only_its_files(plan);
}

// Two machines may have one name, as containers often have. What one of them is making looks like a
// left-over to the other, if locks are not seen from machine to machine.
TEST_CASE("Part_LeftOvers_OnlyThoseOfThisMachineAreRemoved") {
  const Work work;
  const fs::path& plan = work.plan;
  work.make_plan(2);
  make_part(plan, 0, {}, default_backends());
  // part.0-HOST-START-PROCESS.RANDOM
  const std::string name = directory_of(plan, 0).filename().native();
  const std::size_t random = name.rfind('-') + 1, start = name.rfind('-', random - 2) + 1;
  REQUIRE(name.find('-') + 1 < start);
  std::string own = "part.1" + name.substr(name.find('-'));
  own.replace(random, std::string::npos, "0");
  std::string other_machine = own;
  other_machine[start] = other_machine[start] == '0' ? '1' : '0';
  const fs::path in_use = plan / (own + "1");
  for (const fs::path& directory : {plan / own, plan / other_machine, in_use}) {
    fs::create_directory(directory);
    std::ofstream(directory / "records") << "killed";
  }
  {
    const Directory used(in_use);
    REQUIRE(used.lock(true));
    make_part(plan, 1, {}, default_backends());
  }
  CHECK_FALSE(fs::exists(plan / own));
  CHECK(fs::exists(in_use / "records"));
  CHECK(fs::exists(plan / other_machine / "records"));
  std::vector<std::string> warnings;
  const JoinOptions options{
      .warn = [&](const std::string& warning) { warnings.push_back(warning); }};
  CHECK(join(plan, work.path, options).has_store);
  REQUIRE(warnings.size() == 1);
  CHECK_THAT(warnings[0], Catch::Contains("another machine: 2;"));
}

TEST_CASE("Plan_Calibrated_HasOtherSecondsAndNothingElse") {
  const Work work;
  PartsRequest request = work.request(7, "plain");
  const PartsPlan plain = plan_parts(request, default_backends());
  CHECK_FALSE(plain.rates);
  request.plan = work.directory / "measured";
  request.calibrate = true;
  const PartsPlan measured = plan_parts(request, default_backends());
  REQUIRE(measured.rates);
  CHECK(measured.rates->points_per_second > 0);
  CHECK(measured.rates->bytes_per_second > 0);
  CHECK(measured.rates->begin_seconds > 0);
  REQUIRE(measured.parts.size() == plain.parts.size());
  for (std::size_t at = 0; at < plain.parts.size(); ++at) {
    const PlannedPart &one = plain.parts[at], &other = measured.parts[at];
    CHECK(other.first_edge == one.first_edge);
    CHECK(other.records == one.records);
    CHECK(other.faces == one.faces);
    CHECK(other.ghosts == one.ghosts);
    CHECK(other.bytes == one.bytes);
    CHECK(other.seconds > 0);
    CHECK(other.seconds != one.seconds);
  }
  CHECK(read_parts_plan(request.plan).parts[6].seconds == measured.parts[6].seconds);
  make_all(request.plan, 7);
  CHECK(join(request.plan, work.path).has_store);

  request.plan = work.directory / "cancelled";
  request.progress = [](const Progress&) { return false; };
  CHECK(error_of([&] { plan_parts(request, default_backends()); }).code() == ErrorCode::kCancelled);
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(work.directory))
    names.insert(entry.path().filename());
  CHECK(names == std::set<std::string>{"mesh.ply", "plain", "measured", "s.plait"});
}

TEST_CASE("ShardedStore_WithHundredsOfFiles_KeepsFewOpen") {
  Work work(random_sheet(9, 400));
  const fs::path &plan = work.plan, &path = work.path;
  work.max_slot_bytes = std::nullopt;
  constexpr std::uint32_t kParts = 100;
  work.make_plan(kParts);
  make_all(plan, kParts);
  REQUIRE(join(plan, path).has_store);
  const auto open_files = [] {
    return std::distance(fs::directory_iterator("/proc/self/fd"), fs::directory_iterator());
  };
  const auto before = open_files();
  const Store store = Store::open(path, {}, default_backends());
  CHECK(open_files() - before < 10);
  digest(store);
  CHECK(open_files() - before <= 64 + 10);
  CHECK(open_files() - before > 32);
}

TEST_CASE("ShardedStore_OneDamagedTable_ConcernsOnlyItsShard") {
  const Made work(5);
  const fs::path &plan = work.plan, &path = work.path;
  REQUIRE(join(plan, path).has_store);
  fs::remove_all(plan);
  const auto expected = digest(Store::open(path, {}, default_backends()));
  // Writers are refused in words; a whole store has nothing to repair.
  CHECK(error_of([&] { Store::open(path, {.writable = true}, default_backends()); }).code() ==
        ErrorCode::kNotSupported);
  const RepairReport whole = repair(path, {}, default_backends());
  CHECK(whole.whole());
  CHECK(whole.blocks_examined);
  CHECK(whole.rebuilt_count == 0);
  CHECK(digest(Store::open(path, {}, default_backends())) == expected);

  flip_byte(path / "version.1.shard2", 100);
  const StoreCheck check = check_store(path, default_backends());
  REQUIRE(check.damaged.size() == 1);
  CHECK(check.damaged[0].name == "version.1.shard2");
  for (const bool dry_run : {true, false}) {
    const RepairReport lost = repair(path, {.dry_run = dry_run}, default_backends());
    REQUIRE(lost.lost_files.size() == 1);
    CHECK(lost.lost_files[0].name == "version.1.shard2");
    CHECK_THAT(lost.lost_files[0].reason, Catch::Contains("plait part --again"));
  }
}

TEST_CASE("ShardedStore_ManyShardsWithoutTables_IsRefusedBeforeMemoryIsTaken") {
  Work work(random_sheet(9, 400));
  work.max_slot_bytes = std::nullopt;
  work.levels = 1;
  work.normals = false;
  const fs::path &plan = work.plan, &path = work.path;
  work.make_plan(2);
  make_all(plan, 2);
  REQUIRE(join(plan, path).has_store);
  const std::vector<std::byte> before = whole_file(version_file(path));
  VersionDescription version =
      decode_description(std::span(before).subspan(32), 1, "forged", 0, kShards);
  // 600 shards of 60,000 levels: 275 MiB of numbers from a description of a few.
  version.shards.clear();
  for (EdgeId edge = 0; edge < 600; ++edge) version.shards.push_back({edge, 0});
  for (std::uint32_t number = 1; number < 60'000; ++number) {
    version.attributes.push_back(version.attributes.front());
    version.attributes.back().schema.name = "a" + std::to_string(number);
    version.attributes.back().number = number;
  }
  version.next_attribute_number = 60'000;
  forge_version_file(path, encode_version_file(encode_description(version), {}));
  const Error error = error_of([&] { Store::open(path, {}, default_backends()); });
  CHECK(error.code() == ErrorCode::kCorruption);
  CHECK_THAT(error.what(), Catch::Contains("60000 levels in 600 shards"));
}

TEST_CASE("ArrayText_OfNumbers_JoinsNeighbours") {
  CHECK(array_text({}).empty());
  CHECK(array_text(std::vector<std::uint32_t>{3, 17, 18, 19}) == "3,17-19");
  CHECK(array_text(std::vector<std::uint32_t>{0, 1}) == "0-1");
}

}  // namespace plait::test::parts
