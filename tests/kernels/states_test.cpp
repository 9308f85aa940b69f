// What a failed subdivision leaves: what nobody can read or commit until Store::roll_back(), or, if
// it was refused, the store as it was.
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
#include "plait/store_info.h"
#include "plait/subdivide.h"
#include "plait/visit_vertices.h"
#include "support/error_of.h"
#include "support/sanitized.h"
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
    StoreOptions options{.backend = backend};
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

TEST_CASE("Subdivide_AfterACancelledCall_IsRefusedUntilTheStoreIsRolledBack") {
  for (const std::string& backend : usable_backends())
    for (const ExecutorKind executor : {ExecutorKind::kAuto, ExecutorKind::kFused,
                                        ExecutorKind::kSweep, ExecutorKind::kTransparent})
      for (const Scheme scheme : {Scheme::kLoop, Scheme::kButterfly, Scheme::kMidpoint}) {
        SubdivideOptions what{.scheme = scheme,
                              .executor = executor,
                              .levels = 3,
                              .normals = true,
                              .limit = scheme == Scheme::kLoop};
        const std::string expected = expected_digest(what);
        bool cancelled = true;
        for (int calls = 0; cancelled; calls += unless_sanitized(3, 17)) {
          CAPTURE(backend, to_string(executor), to_string(scheme), calls);
          Made made(backend);
          (*made).commit();
          const std::vector<std::byte> before = seen(*made);
          int left = calls;
          what.progress = [&](const Progress&) { return left-- > 0; };
          cancelled = code_of([&] {
                        subdivide(*made, what);
                        throw Error(ErrorCode::kIo, "");
                      }) == ErrorCode::kCancelled;
          if (!cancelled) break;
          what.progress = {};
          CHECK(error_of([&] { digest(*made); }).code() == ErrorCode::kBadState);
          CHECK(has(error_of([&] { (*made).commit(); }), "roll_back"));
          const Error again = error_of([&] { subdivide(*made, what); });
          CHECK(again.code() == ErrorCode::kBadState);
          CHECK(has(again, "roll_back"));
          (*made).roll_back();
          CHECK(seen(*made) == before);
          subdivide(*made, what);
          CHECK(digest(*made).to_string() == expected);
          CHECK((*made).attributes().size() == 2);
          CHECK_NOTHROW((*made).commit());
        }
      }
}

TEST_CASE("Subdivide_OverLevelsOfACommit_IsAllUnfinishedAfterAnErrorAnywhere") {
  for (const ExecutorKind executor : {ExecutorKind::kSweep, ExecutorKind::kTransparent})
    for (const Scheme scheme : {Scheme::kLoop, Scheme::kButterfly, Scheme::kMidpoint}) {
      SubdivideOptions what{.scheme = scheme, .executor = executor, .levels = 2};
      Made made("pread");
      subdivide(*made, what);
      (*made).commit();
      made.store.reset();
      made.store.emplace(Store::open(made.path, {.writable = true}, default_backends()));
      const std::vector<std::byte> before = seen(*made);
      const std::string committed = digest(*made).to_string();
      what.levels = 4;
      const std::string expected = expected_digest(what);
      for (int calls = 0;; ++calls) {
        CAPTURE(to_string(executor), to_string(scheme), calls);
        int left = calls;
        bool changed = false;  // only rings were read before
        what.progress = [&](const Progress& now) {
          changed = changed || now.phase.find("rings") == std::string_view::npos;
          return left-- > 0;
        };
        bool cancelled = false;
        try {
          subdivide(*made, what);
        } catch (const Error& error) {
          REQUIRE(error.code() == ErrorCode::kCancelled);
          cancelled = true;
        }
        if (!cancelled) break;
        if (!changed) {
          CHECK(digest(*made).to_string() == committed);
          continue;
        }
        CHECK(has(error_of([&] { (*made).commit(); }), "of 'position' is unfinished"));
        CHECK(error_of([&] { static_cast<void>(std::as_const(*made).base_bytes(0)); }).code() ==
              ErrorCode::kBadState);
        (*made).roll_back();
        CHECK(seen(*made) == before);
        CHECK(digest(*made).to_string() == committed);
      }
      CHECK(digest(*made).to_string() == expected);
    }
}

TEST_CASE("Subdivide_CancelledAfterCommitsOfLevels_GoesOnFromTheLastOfThem") {
  for (const ExecutorKind executor : {ExecutorKind::kSweep, ExecutorKind::kTransparent}) {
    SubdivideOptions what{.executor = executor, .levels = 4};
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
    (*made).roll_back();
    CHECK((*made).finest_level() == 2);
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

TEST_CASE("Subdivide_ThatFailsInItsSurface_KeepsTheNormalsThatAreThereAndCommitsNothing") {
  for (const ExecutorKind executor :
       {ExecutorKind::kFused, ExecutorKind::kSweep, ExecutorKind::kTransparent})
    for (const bool has_normals : {false, true}) {
      CAPTURE(to_string(executor), has_normals);
      Made made("pread");
      if (has_normals)
        std::ranges::fill((*made).base_records<Vector3<float>>(
                              (*made).add_attribute(schema_of<Vector3<float>>("normal"))),
                          Vector3<float>{7, 7, 7});
      (*made).commit();
      const std::vector<std::byte> before = seen(*made);
      SubdivideOptions what{.executor = executor, .levels = 2, .normals = true, .limit = true};
      what.progress = [](const Progress& now) {
        return now.phase != "subdivision" && now.phase != "normals and limit positions";
      };
      CHECK(error_of([&] { subdivide(*made, what); }).code() == ErrorCode::kCancelled);
      CHECK((*made).has_attribute("normal") == has_normals);
      CHECK_FALSE((*made).has_attribute("limit"));
      if (has_normals)
        CHECK(std::as_const(*made).base_records<Vector3<float>>((*made).attribute("normal"))[0].x ==
              7);
      CHECK(error_of([&] { (*made).commit(); }).code() == ErrorCode::kBadState);
      (*made).roll_back();
      CHECK(seen(*made) == before);
    }
}

TEST_CASE("Subdivide_BesideAttributesOfTheProgram_TouchesNoneWhateverTheirNames") {
  for (const std::string name : {"limit", "normal_anew", "other", "recoded-0"})
    for (const bool unfinished : {false, true}) {
      CAPTURE(name, unfinished);
      Made made("pread");
      subdivide(*made, {.levels = 1});
      const AttributeId id = (*made).add_attribute(schema_of<float>(name), 1);
      visit_vertices(*made, {}, std::tuple{overwrites<float>(name)},
                     [](const VertexRun&, std::span<float> to) { std::ranges::fill(to, 7.0f); });
      (*made).commit();
      const std::uint64_t committed = (*made).sequence();
      const std::string text = digest(*made).to_string();
      if (unfinished)
        CHECK_THROWS_AS(visit_vertices(*made, {}, std::tuple{updates<float>(name)},
                                       [](const VertexRun&, std::span<float>) { throw 1; }),
                        int);
      for (const bool limit : {false, true})
        CHECK_NOTHROW(subdivide(*made, {.levels = 2, .normals = true, .limit = limit}));
      CHECK((*made).attribute(name) == id);
      if (!unfinished) {
        CHECK_NOTHROW((*made).commit());
        continue;
      }
      CHECK(has(error_of([&] { (*made).commit(); }), "of '" + name + "' is unfinished"));
      (*made).roll_back();
      CHECK((*made).sequence() == committed);
      CHECK(digest(*made).to_string() == text);
    }
}

TEST_CASE("Subdivide_AfterAPassOfTheProgramThatFailed_IsRefused") {
  using Point = Vector3<float>;
  for (const int levels : {0, 2}) {
    Made made("pread");
    if (levels > 0) subdivide(*made, {.levels = levels});
    (*made).commit();
    const std::vector<std::byte> before = seen(*made);
    int runs = 0;
    const auto fails = [&](const VertexRun&, std::span<Point> points) {
      points[0].x = 9;
      if (++runs == 1) throw 1;
    };
    CHECK_THROWS_AS(visit_vertices(*made, {}, std::tuple{updates<Point>("position")}, fails), int);
    for (const int wanted : {levels, levels + 1})
      CHECK(has(error_of([&] { subdivide(*made, {.levels = wanted, .normals = true}); }),
                "unfinished"));
    (*made).roll_back();
    CHECK(seen(*made) == before);
    CHECK_NOTHROW(subdivide(*made, {.levels = levels + 1}));
  }
}

TEST_CASE("Subdivide_OverLevelsBeyondItsBudget_ChangesNothingAndSaysWhatTheWholeWorkNeeds") {
  int refused = 0;
  for (const std::string& backend : usable_backends()) {
    if (default_backends().find(backend).traits.in_memory) continue;
    for (std::uint32_t block = 4096; block <= unless_sanitized(16384u, 4096u); block *= 4)
      for (const ExecutorKind executor : {ExecutorKind::kSweep, ExecutorKind::kTransparent})
        for (int start = unless_sanitized(1, 3); start <= 3; ++start)
          for (const bool normals : {false, true}) {
            CAPTURE(backend, block, to_string(executor), start, normals);
            const TemporaryDirectory directory(Medium::kMemory);
            const auto run_with = [&](std::uint64_t budget, const char* name) {
              StoreOptions options{.backend = backend};
              if (backend == "compressed") options.pipeline = "none";
              options.block_bytes = block;
              options.durability = Durability::kNone;
              options.budget_bytes = budget;
              options.io_threads = 0;
              Store store =
                  Store::create(directory.path() / name, BaseMesh::build(random_sheet(5, 30)),
                                options, default_backends());
              add_base_positions(store);
              subdivide(store, {.executor = executor, .levels = start});
              store.commit();
              const std::vector<std::byte> before = seen(store);
              try {
                subdivide(store, {.executor = executor, .levels = 4, .normals = normals});
              } catch (const Error& error) {
                REQUIRE(error.code() == ErrorCode::kBudget);
                CHECK(seen(store) == before);
                const std::uint64_t version = store.sequence();
                CHECK_NOTHROW(store.commit());
                CHECK(store.sequence() == version);
                const std::string text = error.what(), words = "a budget of ";
                REQUIRE(has(error, words));
                return std::stoull(text.substr(text.find(words) + words.size()));
              }
              return 0ull;
            };
            for (const std::uint64_t budget : {64u << 10, 80u << 10, 112u << 10}) {
              unsigned long long needed = 0;
              try {
                needed = run_with(budget, "s.plait");
              } catch (const Error& error) {  // the levels before do not fit either
                REQUIRE(error.code() == ErrorCode::kBudget);
              }
              std::filesystem::remove_all(directory.path() / "s.plait");
              if (needed == 0) continue;
              ++refused;
              CHECK(run_with(needed, "t.plait") == 0);
              std::filesystem::remove_all(directory.path() / "t.plait");
            }
          }
  }
  CHECK(refused > 0);
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
  CHECK(seen(*made) == before);
  CHECK(digest(*made).to_string() == digest_before);
}

TEST_CASE("Subdivide_WhosePipelineEncodesFromWhatItChanges_IsEncodedByTheCommit") {
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
        const SubdivideOptions what{
            .scheme = scheme, .executor = executor, .levels = levels, .normals = normals};
        const std::string expected = expected_digest(what);
        subdivide(*store, what);
        CHECK(digest(*store).to_string() == expected);
        CHECK_NOTHROW((*store).commit());
        CHECK(digest(*store).to_string() == expected);
        CHECK(StoreAccess::level_file(*store, 0, levels).pipeline == "hierarchy,lz4");
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
      CHECK((*made).info().paging.blocks_read + 1 > 0);
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

// Found by acceptance_random_calls_test.
TEST_CASE("SubdivideTransparent_ButterflyOverBlocksEncodedFromBaseRecords_OnlyReadsThese") {
  std::string expected;
  for (const ExecutorKind executor : {ExecutorKind::kSweep, ExecutorKind::kTransparent}) {
    CAPTURE(to_string(executor));
    Made made("compressed", 4 << 20, sheet(6, 5), "hierarchy,zstd:1");
    (*made).add_level(0);  // of zeros, which compress
    (*made).commit();
    subdivide(*made, {.scheme = Scheme::kButterfly, .executor = executor, .levels = 2});
    const std::string found = digest(*made).to_string();
    if (expected.empty()) expected = found;
    CHECK(found == expected);
  }
}
