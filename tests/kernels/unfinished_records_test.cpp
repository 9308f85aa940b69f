// What a pass leaves of base records and levels when it ends early: nobody can read it or commit
// it.
#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "plait/digest.h"
#include "plait/extend/patch.h"
#include "plait/extend/recode_attribute.h"
#include "plait/extend/store_access.h"
#include "plait/patch_writer.h"
#include "plait/reader.h"
#include "plait/registry.h"
#include "plait/subdivide.h"
#include "plait/visit_vertices.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"
#include "support/usable_backends.h"

namespace plait::test {
namespace {

using Point = Vector3<float>;

struct Thrown {};

/// A store with attribute "position" and with "h" of `levels` levels and sevens in its base
/// records, committed.
Store made(const std::string& backend, const std::filesystem::path& path, int levels) {
  const StoreOptions options{
      .backend = backend, .durability = Durability::kNone, .block_bytes = 4096};
  Store store = Store::create(
      default_backends().find(backend).traits.in_memory ? std::filesystem::path() : path,
      BaseMesh::build(octahedron()), options, default_backends());
  add_base_positions(store);
  std::ranges::fill(store.base_records<float>(store.add_attribute(schema_of<float>("h"), levels)),
                    7.0f);
  store.commit();
  return store;
}

/// Writes a part of "h" and then ends early.
struct EarlyEnd {
  std::string name;
  std::function<void(Store&)> run;
};

/// Ends early when it has written to base vertices.
template <class Spec>
void visit_part(Store& store, Spec spec) {
  visit_vertices(store, {}, std::tuple{spec}, [](const VertexRun& run, std::span<float> to) {
    std::ranges::fill(to, 9.0f);
    if (run.level == 0) throw Thrown();
  });
}

std::vector<EarlyEnd> early_ends() {
  return {
      {"visit that overwrites",
       [](Store& store) { CHECK_THROWS_AS(visit_part(store, overwrites<float>("h")), Thrown); }},
      {"visit that updates",
       [](Store& store) { CHECK_THROWS_AS(visit_part(store, updates<float>("h")), Thrown); }},
      {"visit of one vertex after the other",
       [](Store& store) {
         int runs = 0;
         CHECK_THROWS_AS(
             visit_vertices(store, {},
                            std::tuple{rings_of<Point>("position"), overwrites<float>("h")},
                            [&](const VertexRun&, const VertexRings<Point>&, std::span<float> to) {
                              std::ranges::fill(to, 9.0f);
                              if (++runs == 4) throw Thrown();
                            }),
             Thrown);
       }},
      {"patch writer that nobody finishes",
       [](Store& store) {
         PatchWriter writer(store, {.attributes = {"h"}, .last_level = 0});
         const std::vector<float> corners(3, 9.0f);
         writer.write_patch<float>("h", 0, 0, corners);
       }},
      {"patch writer that writes nothing",
       [](Store& store) {
         const PatchWriter writer(store, {.attributes = {"h"}, .last_level = 0});
       }},
      {"patch writer that is finished too early",
       [](Store& store) {
         PatchWriter writer(store, {.attributes = {"h"}, .last_level = 0});
         CHECK(error_of([&] { writer.finish(); }).code() == ErrorCode::kBadState);
       }},
      {"a walk over patches",
       [](Store& store) {
         const auto walk = [&] {
           StorePatches<float> patches(store, store.attribute("h"), 1 << 20);
           patches.base_records()[0] = 9;
           throw Thrown();
         };
         CHECK_THROWS_AS(walk(), Thrown);
       }},
  };
}

}  // namespace

TEST_CASE("BaseRecords_AfterAPassThatEndedEarly_CannotBeReadOrCommitted") {
  for (const std::string& backend : usable_backends())
    for (const int levels : {0, 2})
      for (const EarlyEnd& end : early_ends()) {
        CAPTURE(backend, levels, end.name);
        const TemporaryDirectory directory(Medium::kMemory);
        Store store = made(backend, directory.path() / "s.plait", levels);
        const AttributeId h = store.attribute("h");
        const std::string committed = digest(store).to_string();
        if (end.name == "visit of one vertex after the other" && levels > 0) continue;
        end.run(store);

        const auto refuses = [](const auto& call) {
          const Error error = error_of(call);
          CHECK(error.code() == ErrorCode::kBadState);
          CAPTURE(error.what());
          CHECK(std::string_view(error.what()).find("level 0 of 'h'") != std::string_view::npos);
        };
        refuses([&] { store.commit(); });
        refuses([&] { static_cast<void>(std::as_const(store).base_records<float>(h)); });
        refuses([&] { static_cast<void>(store.base_records<float>(h)); });
        refuses([&] { digest(store, {.level = 0}); });
        refuses([&] { recode_attribute(store, h, *store.options().pipeline, {}); });
        refuses([&] {
          visit_vertices(store, {.level = 0}, std::tuple{reads<float>("h")},
                         [](const VertexRun&, std::span<const float>) {});
        });
        refuses([&] {
          visit_vertices(store, {.level = 0}, std::tuple{updates<float>("h")},
                         [](const VertexRun&, std::span<float>) {});
        });
        {
          const Reader reader(store);
          refuses([&] { reader.read_patch(0, 0); });
          refuses([&] {
            reader.for_each_block<float>("h", 0, 0, 1,
                                         [](std::uint64_t, std::span<const float>) {});
          });
        }
        // Other attributes can be read.
        const Reader others(store, {.attributes = {"position"}});
        CHECK(others.read_patch(0, 0).size() == 1);
        CHECK(std::as_const(store).base_records<Point>(0).size() == 6);
      }
}

TEST_CASE("StoreRollBack_AfterAPassThatEndedEarly_BringsBaseRecordsBack") {
  for (const std::string& backend : usable_backends())
    for (const EarlyEnd& end : early_ends()) {
      CAPTURE(backend, end.name);
      const TemporaryDirectory directory(Medium::kMemory);
      Store store = made(backend, directory.path() / "s.plait", 0);
      const std::string committed = digest(store).to_string();
      end.run(store);
      store.roll_back();
      CHECK(digest(store).to_string() == committed);
      CHECK(std::as_const(store).base_records<float>(store.attribute("h"))[0] == 7);
      CHECK_NOTHROW(store.commit());
      CHECK(store.sequence() == 1);
    }
}

TEST_CASE("BaseRecords_ThatALaterPassOverwrites_AreFinishedAgain") {
  for (const int levels : {0, 2}) {
    Store store = made("memory", {}, levels);
    early_ends().front().run(store);
    visit_vertices(store, {}, std::tuple{overwrites<float>("h")},
                   [](const VertexRun&, std::span<float> to) { std::ranges::fill(to, 3.0f); });
    CHECK(std::as_const(store).base_records<float>(store.attribute("h"))[5] == 3);
    CHECK_NOTHROW(store.commit());
    early_ends().front().run(store);
    PatchWriter writer(store, {.attributes = {"h"}});
    for (FaceId face = 0; face < store.base().face_count(); ++face) {
      const std::vector<float> records(levels == 0 ? 3 : 15, 4.0f);
      writer.write_patch<float>("h", face, levels, records);
    }
    writer.finish();
    CHECK(std::as_const(store).base_records<float>(store.attribute("h"))[5] == 4);
    CHECK_NOTHROW(store.commit());
  }
}

TEST_CASE("VisitVertices_ThatIsRefused_LeavesNothingUnfinished") {
  Store store = made("memory", {}, 2);
  const Reader reader(store);
  CHECK(error_of([&] { visit_part(store, overwrites<float>("h")); }).code() == ErrorCode::kBusy);
  CHECK_NOTHROW(digest(store));
}

TEST_CASE("BaseRecords_WhileAPassOverThemIsUnderWay_CannotBeRead") {
  for (const int levels : {0, 2}) {
    Store store = made("memory", {}, levels);
    int refused = 0, runs = 0;
    visit_vertices(store, {}, std::tuple{updates<float>("h")},
                   [&](const VertexRun&, std::span<float>) {
                     ++runs;
                     if (code_of([&] { static_cast<void>(std::as_const(store).base_bytes(1)); }) ==
                         ErrorCode::kBadState)
                       ++refused;
                   });
    CHECK(runs > 0);
    CHECK(refused == runs);
    CHECK_NOTHROW(store.commit());
  }
}

TEST_CASE("PatchWriterFinish_ASecondTime_IsAnError") {
  Store store = made("memory", {}, 0);
  PatchWriter writer(store, {.attributes = {"h"}});
  const std::vector<float> corners(3, 2.0f);
  for (FaceId face = 0; face < store.base().face_count(); ++face)
    writer.write_patch<float>("h", face, 0, corners);
  writer.finish();
  CHECK(error_of([&] { writer.finish(); }).code() == ErrorCode::kBadState);
  CHECK_NOTHROW(writer.statistics());
  CHECK_NOTHROW(store.commit());
}

// In a build with assertions the pager checks that no frame is dropped that another one holds.
TEST_CASE("StoreRemoveAttribute_WhoseBlocksAreContextOfOthers_LetsGoOfTheFinerOnesFirst") {
  for (const int io_threads : {0, 2})
    for (const int way : {0, 1, 2, 3, 4}) {
      CAPTURE(io_threads, way);
      const TemporaryDirectory directory(Medium::kMemory);
      const StoreOptions options{.backend = "compressed",
                                 .pipeline = "hierarchy,bitpack",
                                 .durability = Durability::kNone,
                                 .block_bytes = 4096,
                                 .io_threads = io_threads};
      Store store =
          Store::create(directory.path() / "s.plait", BaseMesh::build(random_sheet(5, 60)), options,
                        default_backends());
      add_base_positions(store);
      subdivide(store,
                {.scheme = Scheme::kButterfly, .executor = ExecutorKind::kSweep, .levels = 4});
      if (way == 0) store.remove_attribute(0);
      if (way == 1) store.roll_back();
      if (way == 2) store.close();
      if (way >= 3) {
        int left = way == 3 ? 20 : 1 << 30;
        const std::string before = digest(store).to_string();
        RecodeOptions recode;
        recode.verify = true;
        recode.progress = [&](const Progress&) { return left-- > 0; };
        const ErrorCode code =
            code_of([&] { recode_attribute(store, 0, LevelPipelines("hierarchy,lz4"), recode); });
        CHECK(code == ErrorCode::kCancelled);  // also what code_of() gives for success
        CHECK(digest(store).to_string() == before);
      }
    }
}

}  // namespace plait::test
