// What a failed subdivision leaves: levels that nobody can read and that the same call makes again,
// or, if it did not fit into the budget, the store as it was.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "plait/digest.h"
#include "plait/extend/store_access.h"
#include "plait/reader.h"
#include "plait/registry.h"
#include "plait/subdivide.h"
#include "plait/visit_vertices.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"
#include "support/usable_backends.h"

using namespace plait;
using namespace plait::test;

namespace {

/// A store of the backend, with base positions.
struct Made {
  explicit Made(const std::string& backend, std::uint64_t budget_bytes = 4 << 20,
                const IndexedMesh& mesh = random_sheet(5, 60), const std::string& pipeline = {}) {
    StoreOptions options;
    options.backend = backend;
    if (!pipeline.empty()) options.pipeline = pipeline;
    options.block_bytes = 4096;
    options.durability = Durability::kNone;
    options.budget_bytes = budget_bytes;
    options.io_threads = 0;
    if (!default_backends().find(backend).traits.in_memory) path = directory.path() / "s.plait";
    store.emplace(Store::create(path, BaseMesh::build(mesh), options, default_backends()));
    add_base_positions(*store);
  }
  Store& operator*() { return *store; }

  TemporaryDirectory directory{Medium::kMemory};
  std::filesystem::path path;
  std::optional<Store> store;
};

bool has(const Error& error, const std::string& words) {
  return std::string_view(error.what()).find(words) != std::string_view::npos;
}

std::string expected_digest(const SubdivideOptions& wanted) {
  Made made("memory");
  SubdivideOptions plain = wanted;
  plain.progress = {};
  subdivide(*made, plain);
  return digest(*made).to_string();
}

bool has_unfinished_positions(const Store& store) {
  for (int level = 1; level <= store.attributes()[0].finest_level; ++level)
    if (!StoreAccess::level_file(store, 0, level).is_finished()) return true;
  return false;
}

/// The records and names that a program can see without a level.
std::vector<std::byte> seen(const Store& store) {
  std::vector<std::byte> all;
  for (AttributeId id = 0; id < store.attributes().size(); ++id) {
    const auto bytes = store.base_bytes(id);
    all.insert(all.end(), bytes.begin(), bytes.end());
    for (const char letter : store.attributes()[id].schema.name) all.push_back(std::byte(letter));
    all.push_back(std::byte(store.attributes()[id].finest_level));
  }
  for (const char letter : store.provenance().scheme) all.push_back(std::byte(letter));
  return all;
}

}  // namespace

TEST_CASE("Subdivide_AfterACancelledCall_MakesTheUnfinishedLevelsAgain") {
  for (const std::string& backend : usable_backends())
    for (const ExecutorKind executor : {ExecutorKind::kAuto, ExecutorKind::kFused,
                                        ExecutorKind::kSweep, ExecutorKind::kTransparent})
      for (const Scheme scheme : {Scheme::kLoop, Scheme::kButterfly, Scheme::kMidpoint}) {
        SubdivideOptions what;
        what.scheme = scheme;
        what.executor = executor;
        what.levels = 3;
        what.normals = true;
        what.limit = scheme == Scheme::kLoop;
        const std::string expected = expected_digest(what);
        bool cancelled = true;
        for (int calls = 0; cancelled; calls += 3) {
          CAPTURE(backend, to_string(executor), to_string(scheme), calls);
          Made made(backend);
          const std::vector<std::byte> before = seen(*made);
          int left = calls;
          what.progress = [&](const Progress&) { return left-- > 0; };
          cancelled = code_of([&] {
                        subdivide(*made, what);
                        throw Error(ErrorCode::kIo, "");
                      }) == ErrorCode::kCancelled;
          if (!cancelled) break;
          const auto base = std::as_const(*made).base_bytes(0);
          if (has_unfinished_positions(*made))
            CHECK(std::equal(base.begin(), base.end(), before.begin()));
          CHECK(error_of([&] { digest(*made); }).code() == ErrorCode::kBadState);
          CHECK(has(error_of([&] { (*made).commit(); }), "unfinished"));
          // Nothing that the library says leads to success over unfinished levels.
          what.progress = {};
          subdivide(*made, what);
          CHECK(digest(*made).to_string() == expected);
          CHECK((*made).attributes().size() == 2);
          CHECK_NOTHROW((*made).commit());
        }
      }
}

TEST_CASE("Subdivide_CancelledAfterCommitsOfLevels_StartsAgainAndGivesTheSameBits") {
  for (const ExecutorKind executor : {ExecutorKind::kSweep, ExecutorKind::kTransparent}) {
    SubdivideOptions what;
    what.levels = 4;
    what.executor = executor;
    const std::string expected = expected_digest(what);
    Made made("pread");
    bool enough = false;
    what.level_done = [&](int level) {
      (*made).commit();
      enough = level == 2;
    };
    what.progress = [&](const Progress&) { return !enough; };
    CHECK(error_of([&] { subdivide(*made, what); }).code() == ErrorCode::kCancelled);
    const std::uint64_t committed = (*made).sequence();
    what.progress = {};
    what.level_done = {};
    subdivide(*made, what);
    CHECK(digest(*made).to_string() == expected);
    (*made).commit();
    CHECK((*made).sequence() == committed + 1);
    made.store.reset();
    Store again = Store::open(made.path, {}, default_backends());
    CHECK(digest(again).to_string() == expected);
  }
}

TEST_CASE("Subdivide_AfterOneThatWasCancelledInItsNormals_GoesOnFromTheWholePositions") {
  SubdivideOptions loop{.executor = ExecutorKind::kSweep, .levels = 2, .normals = true};
  const SubdivideOptions other{.scheme = Scheme::kMidpoint, .levels = 3, .normals = true},
      coarser{.scheme = Scheme::kMidpoint, .levels = 0, .normals = true};
  for (const SubdivideOptions& next : {other, coarser}) {
    Made whole("memory"), cancelled("memory");
    loop.progress = {};
    loop.normals = false;
    subdivide(*whole, loop);
    subdivide(*whole, next);
    loop.progress = [](const Progress& now) { return now.phase != "normals"; };
    loop.normals = true;
    CHECK(error_of([&] { subdivide(*cancelled, loop); }).code() == ErrorCode::kCancelled);
    subdivide(*cancelled, next);
    CHECK((*cancelled).finest_level() == std::max(2, next.levels));
    CHECK(digest(*cancelled) == digest(*whole));
  }
}

TEST_CASE("Subdivide_UnfinishedLevelsWhoseBeginningIsNotKnown_IsRefused") {
  Made made("pread");
  SubdivideOptions what{.executor = ExecutorKind::kSweep, .levels = 2};
  subdivide(*made, what);
  (*made).commit();
  made.store.reset();
  made.store.emplace(Store::open(made.path, {.writable = true}, default_backends()));
  const std::vector<std::byte> before = seen(*made);
  what.levels = 3;
  int left = 3;
  what.progress = [&](const Progress&) { return left-- > 0; };
  CHECK(error_of([&] { subdivide(*made, what); }).code() == ErrorCode::kCancelled);
  const auto base = std::as_const(*made).base_bytes(0);
  CHECK(std::equal(base.begin(), base.end(), before.begin()));
  what.progress = {};
  for (const Scheme scheme : {Scheme::kLoop, Scheme::kMidpoint}) {
    what.scheme = scheme;
    const Error error = error_of([&] { subdivide(*made, what); });
    CHECK(error.code() == ErrorCode::kBadState);
    CHECK(has(error, "roll_back"));
  }
  (*made).roll_back();
  what.scheme = Scheme::kLoop;
  CHECK(seen(*made) == before);
  const std::string expected = expected_digest(what);
  subdivide(*made, what);
  CHECK(digest(*made).to_string() == expected);
}

TEST_CASE("Subdivide_LevelsThatAnotherPassChanged_AreNotMadeAgainWithoutIt") {
  using Point = Vector3<float>;
  Made made("memory");
  SubdivideOptions what{.executor = ExecutorKind::kSweep, .levels = 1};
  subdivide(*made, what);
  visit_vertices(*made, {}, std::tuple{updates<Point>("position")},
                 [](const VertexRun&, std::span<Point> points) {
                   for (Point& point : points) point.z += 1;
                 });
  what.levels = 2;
  int left = 3;
  what.progress = [&](const Progress&) { return left-- > 0; };
  CHECK(error_of([&] { subdivide(*made, what); }).code() == ErrorCode::kCancelled);
  what.progress = {};
  CHECK(error_of([&] { subdivide(*made, what); }).code() == ErrorCode::kBadState);
}

TEST_CASE("Subdivide_BeyondItsBudget_ChangesNothingAndSaysWhatTheWholeWorkNeeds") {
  for (const std::string backend : {"pread", "memory", "compressed"})
    for (const ExecutorKind executor :
         {ExecutorKind::kFused, ExecutorKind::kSweep, ExecutorKind::kTransparent}) {
      CAPTURE(backend, to_string(executor));
      SubdivideOptions what{.executor = executor, .levels = 6, .normals = true};
      Made made(backend, 64 << 10, random_sheet(5, 300));
      const std::vector<std::byte> before = seen(*made);
      const Error error = error_of([&] { subdivide(*made, what); });
      CHECK(error.code() == ErrorCode::kBudget);
      CAPTURE(error.what());
      CHECK(seen(*made) == before);
      CHECK_NOTHROW((*made).commit());
      const std::string text = error.what(), words = "a budget of ";
      REQUIRE(has(error, words));
      const std::uint64_t needed = std::stoull(text.substr(text.find(words) + words.size()));
      Made larger(backend, needed, random_sheet(5, 300));
      CHECK_NOTHROW(subdivide(*larger, what));
    }
}

TEST_CASE("SubdivideFused_WithNormalsThatAreThere_ReplacesThem") {
  for (const ExecutorKind executor : {ExecutorKind::kAuto, ExecutorKind::kFused}) {
    SubdivideOptions what{.executor = executor, .levels = 3, .normals = true};
    const std::string expected = expected_digest(what);
    Made made("memory");
    (*made).add_attribute(schema_of<Vector3<float>>("normal"), 2);
    (*made).add_attribute({"color", ComponentType::kUint8, 3});
    subdivide(*made, what);
    (*made).remove_attribute((*made).attribute("color"));
    CHECK(digest(*made).to_string() == expected);
    CHECK_NOTHROW((*made).commit());
  }
}

TEST_CASE("SubdivideFused_ThatIsRefused_ChangesNothing") {
  Made made("memory");
  subdivide(*made, {.scheme = Scheme::kMidpoint, .levels = 1});
  const std::vector<std::byte> before = seen(*made);
  const std::string digest_before = digest(*made).to_string();
  CHECK(error_of([&] {
          subdivide(*made, {.executor = ExecutorKind::kFused, .levels = 3, .normals = true});
        }).code() == ErrorCode::kNotSupported);
  CHECK(seen(*made) == before);
  (*made).add_attribute(schema_of<Vector3<float>>("normal_anew"));
  (*made).add_attribute(schema_of<Vector3<float>>("normal"));
  CHECK(error_of([&] { subdivide(*made, {.levels = 3, .normals = true}); }).code() ==
        ErrorCode::kInvalidArgument);
  (*made).remove_attribute((*made).attribute("normal_anew"));
  (*made).remove_attribute((*made).attribute("normal"));
  CHECK(seen(*made) == before);
  CHECK(digest(*made).to_string() == digest_before);
}

TEST_CASE("Subdivide_WhosePipelineEncodesFromWhatItChanges_IsRefusedAndChangesNothing") {
  const auto made = [] {
    return Made("compressed", 4 << 20, random_sheet(5, 60), "hierarchy,lz4");
  };
  for (const ExecutorKind executor : {ExecutorKind::kAuto, ExecutorKind::kFused,
                                      ExecutorKind::kSweep, ExecutorKind::kTransparent})
    for (const Scheme scheme : {Scheme::kLoop, Scheme::kButterfly, Scheme::kMidpoint})
      for (const auto& [levels, normals] :
           {std::pair(1, false), std::pair(1, true), std::pair(3, false), std::pair(3, true)}) {
        CAPTURE(to_string(executor), to_string(scheme), levels, normals);
        Made store = made();
        const std::vector<std::byte> before = seen(*store);
        const SubdivideOptions what{
            .scheme = scheme, .executor = executor, .levels = levels, .normals = normals};
        if (scheme != Scheme::kLoop && executor != ExecutorKind::kFused &&
            (!normals || levels == 1)) {
          subdivide(*store, what);
          CHECK(digest(*store).to_string() == expected_digest(what));
          continue;
        }
        const Error error = error_of([&] { subdivide(*store, what); });
        CHECK(error.code() == ErrorCode::kBadState);
        CHECK(has(error, "encoded from"));
        CHECK(seen(*store) == before);
        CHECK_NOTHROW((*store).commit());
      }
}

TEST_CASE("Subdivide_WithCallbacksThatCallBack_RefusesWhatWouldTakeItsGround") {
  for (const ExecutorKind executor :
       {ExecutorKind::kFused, ExecutorKind::kSweep, ExecutorKind::kTransparent}) {
    CAPTURE(to_string(executor));
    SubdivideOptions what{.executor = executor, .levels = 3, .normals = true};
    const std::string expected = expected_digest(what);
    Made made("pread");
    int refused = 0;
    const auto call_back = [&](bool may_commit) {
      const auto refuses = [&](const auto& call) {
        const Error error = error_of(call);
        CHECK(error.code() == ErrorCode::kBadState);
        ++refused;
      };
      refuses([&] { (*made).close(); });
      refuses([&] { (*made).remove_attribute(0); });
      refuses([&] { (*made).replace_attribute(0, 0); });
      refuses([&] { subdivide(*made, {.levels = 4, .normals = true}); });
      if (may_commit)
        CHECK_NOTHROW((*made).commit());
      else
        refuses([&] { (*made).commit(); });
      CHECK((*made).finest_level() >= 0);
      CHECK((*made).statistics().blocks_read + 1 > 0);
    };
    what.progress = [&](const Progress&) {
      call_back(false);
      return true;
    };
    if (executor != ExecutorKind::kFused) what.level_done = [&](int) { call_back(true); };
    subdivide(*made, what);
    CHECK(refused > 0);
    CHECK(digest(*made).to_string() == expected);
  }
}

TEST_CASE("AddBasePositions_TooLargeForFloat32_IsRefusedAndFloat64TakesThem") {
  IndexedMesh mesh = tetrahedron();
  mesh.positions[2].y = -1e300;
  Store store = Store::create({}, BaseMesh::build(mesh), {.backend = "memory"}, default_backends());
  const Error error = error_of([&] { add_base_positions(store); });
  CHECK(error.code() == ErrorCode::kInvalidArgument);
  CHECK(has(error, "vertex 2"));
  CHECK(has(error, "-1e+300"));
  CHECK(store.attributes().empty());
  CHECK(error_of([&] { rebase(store.base(), 1, Scheme()); }).code() == ErrorCode::kInvalidArgument);
  add_base_positions(store, ComponentType::kFloat64);
  CHECK(std::as_const(store).base_records<Vector3<double>>(0)[2].y == -1e300);
}

TEST_CASE("StoreReplaceAttribute_OfSubdividedPositionsByOtherRecords_IsRefused") {
  Made made("memory");
  subdivide(*made, {.levels = 2});
  const AttributeId bytes = (*made).add_attribute({"bytes", ComponentType::kUint8, 3}, 2);
  CHECK(error_of([&] { (*made).replace_attribute(0, bytes); }).code() ==
        ErrorCode::kInvalidArgument);
  const AttributeId same = (*made).add_attribute(schema_of<Vector3<float>>("same"), 2);
  CHECK_NOTHROW((*made).replace_attribute(0, same));
}

// Found by acceptance_random_calls_test.
TEST_CASE("Subdivide_FusedToTheBaseLevel_MakesNormalsOfBaseVertices") {
  std::string expected;
  for (const ExecutorKind executor :
       {ExecutorKind::kSweep, ExecutorKind::kTransparent, ExecutorKind::kFused}) {
    CAPTURE(to_string(executor));
    Store store =
        Store::create({}, BaseMesh::build(octahedron()), {.backend = "memory"}, default_backends());
    add_base_positions(store);
    subdivide(store, {.executor = executor, .levels = 0, .normals = true});
    CHECK(store.finest_level() == 0);
    const std::string found = digest(store).to_string();
    if (expected.empty()) expected = found;
    CHECK(found == expected);
  }
}
