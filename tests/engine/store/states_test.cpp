// What a store refuses: calls of a closed store, changes while it has readers or views, and changes
// from a callback of a pass.
#include <catch2/catch.hpp>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/store/sample_store.h"
#include "plait/digest.h"
#include "plait/extend/patch.h"
#include "plait/extend/store_access.h"
#include "plait/extend/sweep.h"
#include "plait/notes.h"
#include "plait/reader.h"
#include "plait/registry.h"
#include "plait/store_info.h"
#include "plait/verify.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

using Point = Vector3<float>;

/// A committed store in memory with attributes "position" and "other" of three levels.
Store sample_in_memory() {
  Store store = Store::create({}, BaseMesh::build(random_sheet(5, 40)), sample_options("memory"),
                              default_backends());
  add_sample(store, sample_schemas()[0], 3);
  AttributeSchema other = sample_schemas()[0];
  other.name = "other";
  add_sample(store, other, 3);
  store.commit();
  return store;
}

struct NamedCall {
  std::string name;
  std::function<void(Store&)> call;
};

/// The calls that change what attributes, levels and records a store has.
std::vector<NamedCall> changes() {
  return {
      {"add_attribute",
       [](Store& s) {
         s.add_attribute({"new", ComponentType::kUint8, 1});
       }},
      {"add_attribute with levels",
       [](Store& s) {
         s.add_attribute({"new", ComponentType::kUint8, 1}, 2);
       }},
      {"add_level", [](Store& s) { s.add_level(0); }},
      {"set_pipeline", [](Store& s) { s.set_pipeline(0, "none"); }},
      {"remove_attribute", [](Store& s) { s.remove_attribute(0); }},
      {"replace_attribute", [](Store& s) { s.replace_attribute(0, 1); }},
      {"base_bytes", [](Store& s) { s.base_bytes(0); }},
      {"base_records", [](Store& s) { s.base_records<Point>(0); }},
      {"add_face_attribute",
       [](Store& s) {
         s.notes().add_face_attribute({"new", ComponentType::kUint8, 1});
       }},
      {"set_text", [](Store& s) { s.notes().set_text("unit", "mm"); }},
      {"set_provenance", [](Store& s) { StoreAccess::set_provenance(s, {}); }},
  };
}

std::vector<NamedCall> with_ends(std::vector<NamedCall> calls) {
  calls.push_back({"commit", [](Store& s) { s.commit(); }});
  calls.push_back({"roll_back", [](Store& s) { s.roll_back(); }});
  calls.push_back({"close", [](Store& s) { s.close(); }});
  return calls;
}

SweepPass pass_of(Access access, int level = 3) {
  return {.name = "test",
          .accesses = {{0, level, level, access}},
          .kernel = [](const SweepView&, EdgeId, int) {}};
}

}  // namespace

TEST_CASE("Store_ClosedOrMovedFrom_RefusesEveryCall") {
  const bool closed = GENERATE(true, false);
  CAPTURE(closed);
  Store store = sample_in_memory();
  std::optional<Store> other;
  if (closed)
    store.close();
  else
    other = std::move(store);
  std::vector<NamedCall> calls = changes();
  for (const NamedCall& more : std::vector<NamedCall>{
           {"commit", [](Store& s) { s.commit(); }},
           {"roll_back", [](Store& s) { s.roll_back(); }},
           {"path", [](Store& s) { s.path(); }},
           {"base", [](Store& s) { s.base(); }},
           {"options", [](Store& s) { s.options(); }},
           {"sequence", [](Store& s) { s.sequence(); }},
           {"info", [](Store& s) { s.info(); }},
           {"notes", [](Store& s) { s.notes(); }},
           {"const notes", [](Store& s) { std::as_const(s).notes(); }},
           {"provenance", [](Store& s) { s.provenance(); }},
           {"base_level", [](Store& s) { s.base_level(); }},
           {"finest_level", [](Store& s) { s.finest_level(); }},
           {"attributes", [](Store& s) { s.attributes(); }},
           {"attribute", [](Store& s) { s.attribute("position"); }},
           {"has_attribute", [](Store& s) { s.has_attribute("position"); }},
           {"const base_bytes", [](Store& s) { std::as_const(s).base_bytes(0); }},
           {"const base_records", [](Store& s) { std::as_const(s).base_records<Point>(0); }},
           {"Reader", [](Store& s) { Reader reader(s); }},
           {"digest", [](Store& s) { digest(s); }},
           {"verify", [](Store& s) { verify(s); }},
           {"sweep", [](Store& s) { sweep(s, pass_of(Access::kUpdate), {}); }},
           {"open_session", [](Store& s) { StoreAccess::open_session(s); }},
           {"pager", [](Store& s) { StoreAccess::pager(s); }},
           {"level_file", [](Store& s) { StoreAccess::level_file(s, 0, 1); }},
       })
    calls.push_back(more);
  for (const auto& [name, call] : calls) {
    CAPTURE(name);
    const Error error = error_of([&] { call(store); });
    CHECK(error.code() == ErrorCode::kBadState);
    CHECK(names(error, {"closed", "moved"}));
  }
  CHECK_NOTHROW(store.close());
  if (other) CHECK(other->sequence() == 1);
  store = sample_in_memory();
  CHECK(store.sequence() == 1);
}

TEST_CASE("Store_WithReadersOrViews_RefusesChangesAndNamesBoth") {
  Store store = sample_in_memory();
  const Digest before = digest(store);
  std::vector<NamedCall> calls = with_ends(changes());
  calls.push_back({"sweep", [](Store& s) { sweep(s, pass_of(Access::kUpdate), {}); }});
  calls.push_back({"StorePatches", [](Store& s) {
                     StorePatches<Point> patches(s, 0, 1 << 20);
                     patches.activate(3, 1, 3);
                   }});
  std::optional<Reader> reader(std::in_place, std::as_const(store));
  std::optional<PatchView> view = reader->read_patch(0, 3);
  const auto refused = [&](const std::string& readers, const std::string& views) {
    for (const auto& [name, call] : calls) {
      CAPTURE(name);
      const Error error = error_of([&] { call(store); });
      CHECK(error.code() == ErrorCode::kBusy);
      CHECK(names(error, {readers, views}));
    }
  };
  refused("1 reader ", "1 open view:");
  Reader second = std::move(*reader);
  refused("1 reader ", "1 open view:");
  reader.emplace(std::as_const(store));
  *reader = std::move(second);
  refused("1 reader ", "1 open view:");
  reader.reset();
  refused("0 readers ", "1 open view:");
  view.reset();
  CHECK(digest(store) == before);
  CHECK_NOTHROW(sweep(store, pass_of(Access::kUpdate), {}));
  CHECK_NOTHROW(store.remove_attribute(1));
  CHECK_NOTHROW(store.close());
}

TEST_CASE("AttributeView_OfATemporaryPatch_KeepsItsPins") {
  Store store = sample_in_memory();
  const Reader reader(store, {.attributes = {"position"}});
  {
    const AttributeView<Point> kept = reader.read_patch(3, 3).attribute<Point>("position");
    const RecordView records = reader.read_patch(3, 3).records("position");
    CHECK(reader.view_count() == 2);
    const PatchView patch = reader.read_patch(3, 3);
    for (std::int64_t j = 0; j <= patch.size(); ++j)
      for (std::int64_t i = 0; i + j <= patch.size(); ++i) {
        CHECK(&kept.at(i, j) == &patch.attribute<Point>("position").at(i, j));
        CHECK(records.at(i, j).data() == patch.records("position").at(i, j).data());
      }
  }
  CHECK(reader.view_count() == 0);
}

TEST_CASE("Pass_WithACallbackThatCallsBack_RefusesChangesAndLetsItRead") {
  const Access access = GENERATE(Access::kRead, Access::kUpdate, Access::kOverwrite);
  Store store = sample_in_memory();
  std::uint64_t calls_made = 0, callbacks = 0;
  std::vector<NamedCall> calls = with_ends(changes());
  calls.push_back({"sweep", [](Store& s) { sweep(s, pass_of(Access::kUpdate, 1), {}); }});
  SweepOptions options;
  options.progress = [&](const Progress&) {
    if (callbacks++ > 0) return true;
    for (const auto& [name, call] : calls) {
      CAPTURE(name);
      const Error error = error_of([&] { call(store); });
      CHECK(error.code() == ErrorCode::kBadState);
      CHECK(names(error, {"under way"}));
      ++calls_made;
    }
    CHECK(store.info().paging.blocks_read + 1 > 0);
    CHECK(std::as_const(store).base_bytes(0).size() > 0);
    const Reader reader(store, {.attributes = {"other"}});
    CHECK(reader.read_patch(0, 3).level() == 3);
    CHECK_NOTHROW(sweep(store, pass_of(Access::kRead, 1), {}));
    // The level that the pass writes has the records of no moment.
    const Reader of_written(store, {.attributes = {"position"}});
    if (access == Access::kRead) {
      CHECK_NOTHROW(of_written.read_patch(0, 3));
      CHECK_NOTHROW(digest(store));
    } else {
      CHECK(error_of([&] { of_written.read_patch(0, 3); }).code() == ErrorCode::kBadState);
      CHECK(error_of([&] { digest(store); }).code() == ErrorCode::kBadState);
      CHECK(error_of([&] { sweep(store, pass_of(Access::kRead), {}); }).code() ==
            ErrorCode::kBadState);
      CHECK_NOTHROW(of_written.read_patch(0, 2));
    }
    return true;
  };
  sweep(store, pass_of(access), options);
  CHECK(calls_made == calls.size());
  CHECK_NOTHROW(store.commit());
  CHECK_NOTHROW(store.remove_attribute(0));
}

TEST_CASE("Pass_WhoseStoreIsDestroyedInItsCallback_EndsWithAnError") {
  std::optional<Store> store = sample_in_memory();
  Store moved_to = sample_in_memory();
  DigestOptions options;
  options.progress = [&](const Progress&) {
    moved_to = std::move(*store);
    return true;
  };
  CHECK(error_of([&] { digest(*store, options); }).code() == ErrorCode::kBadState);
  CHECK(moved_to.finest_level() == 3);
}

TEST_CASE("Level_ThatACancelledPassLeft_IsUnreadableUntilItIsOverwritten") {
  Store store = sample_in_memory();
  SweepOptions cancelling;
  cancelling.progress = [](const Progress&) { return false; };
  const Access access = GENERATE(Access::kUpdate, Access::kOverwrite);
  CHECK(error_of([&] { sweep(store, pass_of(access, 2), cancelling); }).code() ==
        ErrorCode::kCancelled);
  const auto refused = [&](const std::function<void()>& call) {
    const Error error = error_of(call);
    CHECK(error.code() == ErrorCode::kBadState);
    CHECK(names(error, {"level 2", "'position'", "unfinished"}));
  };
  const auto checked = [&] {
    const Reader reader(store), of_other(store, {.attributes = {"other"}});
    refused([&] { reader.read_patch(0, 3); });
    refused([&] { reader.read_patch(0, 2); });
    refused([&] { reader.faces_in_box({}, "position"); });
    refused([&] { reader.for_each_block<Point>("position", 2, 0, 1, [](auto, auto) {}); });
    CHECK_NOTHROW(reader.read_patch(0, 1));
    CHECK_NOTHROW(reader.for_each_block<Point>("position", 3, 0, 1, [](auto, auto) {}));
    CHECK_NOTHROW(of_other.read_patch(0, 3));
  };
  checked();
  refused([&] { digest(store); });
  refused([&] { digest(store, {.level = 2}); });
  CHECK_NOTHROW(digest(store, {.level = 3}));
  refused([&] { sweep(store, pass_of(Access::kRead, 2), {}); });
  refused([&] { sweep(store, pass_of(Access::kUpdate, 2), {}); });
  refused([&] {
    StorePatches<Point> patches(store, 0, 1 << 20);
    patches.activate(3, 1, 0);
  });
  CHECK(names(error_of([&] { store.commit(); }), {"level 2", "'position'", "unfinished"}));
  sweep(store, pass_of(Access::kOverwrite, 2), {});
  CHECK_NOTHROW(digest(store));
  CHECK_NOTHROW(store.commit());
}

TEST_CASE("StoreCreate_InMemoryWithAPath_IsRefused") {
  const TemporaryDirectory directory;
  const std::filesystem::path path = directory.path() / "s.plait";
  const Error error = error_of([&] {
    Store::create(path, BaseMesh::build(tetrahedron()), sample_options("memory"),
                  default_backends());
  });
  CHECK(error.code() == ErrorCode::kInvalidArgument);
  CHECK(names(error, {"memory", path.native()}));
  CHECK(!std::filesystem::exists(path));
}

TEST_CASE("StoreCommit_WithoutAChange_MakesNoVersion") {
  const auto backend = GENERATE(as<std::string>(), "memory", "pread", "compressed");
  CAPTURE(backend);
  const TemporaryDirectory directory;
  const std::filesystem::path path = backend == "memory" ? "" : directory.path() / "s.plait";
  Store store = Store::create(path, BaseMesh::build(random_sheet(5, 40)), sample_options(backend),
                              default_backends());
  store.commit();
  CHECK(store.sequence() == 1);
  const AttributeId id = add_sample(store, sample_schemas()[0], 2);
  const std::span<std::byte> base = store.base_bytes(id);
  std::uint64_t sequence = 1;
  const auto commits = [&](std::uint64_t versions) {
    sequence += versions;
    store.commit();
    CHECK(store.sequence() == sequence);
    store.commit();
    digest(store);
    store.commit();
    CHECK(store.sequence() == sequence);
  };
  commits(1);
  for (const std::size_t at : {3u, 4u, 3u}) {
    base[at] ^= std::byte{1};  // records that the program got before the first of these commits
    commits(1);
  }
  store.base_bytes(id);
  commits(0);
  sweep(store, pass_of(Access::kUpdate, 2), {});
  commits(1);
  {
    Session session = StoreAccess::open_session(store);
    session.pin(StoreAccess::level_file(store, id, 1), 0, Access::kUpdate).bytes()[0] ^=
        std::byte{1};
  }
  commits(1);
  store.add_level(id);
  commits(1);
  store.add_level(id);
  store.roll_back();
  commits(0);
  if (path.empty()) return;
  store.close();
  store = Store::open(path, {.writable = true}, default_backends());
  commits(0);
  StoreAccess::base_bytes(store, 0, Access::kUpdate)[5] ^= std::byte{1};  // as a pass does
  commits(1);
  store.base_bytes(0)[3] ^= std::byte{1};
  commits(1);
}
