// The sweep executor: what a kernel is called for, sees and writes.
#include "plait/extend/sweep.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <cstring>
#include <string>

#include "engine/execution/naive_reach.h"
#include "engine/store/sample_store.h"
#include "execution/sweep/sweep_window.h"
#include "plait/extend/store_access.h"
#include "plait/registry.h"
#include "plait/store_info.h"
#include "support/counting_backend.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

/// A record type of a program's own.
struct Spin {
  std::int16_t parts[4];
};

}  // namespace

namespace plait {
template <>
struct RecordTraits<Spin> {
  static constexpr ComponentType kType = ComponentType::kInt16;
  static constexpr std::uint32_t kComponents = 4;
};
}  // namespace plait

namespace {

Store sweep_in_memory(const IndexedMesh& mesh, int base_level = 0) {
  StoreOptions options = sample_options("memory");
  options.budget_bytes = 64 << 20;
  return Store::create({}, BaseMesh::build(mesh), options, default_backends(),
                       {.base_level = base_level});
}

/// A committed store in a directory of its own.
struct SweptOnDisk {
  SweptOnDisk(const std::string& backend, const IndexedMesh& mesh, int levels) {
    Store store =
        Store::create(path, BaseMesh::build(mesh), sample_options(backend), default_backends());
    add_sample(store, sample_schemas()[0], levels);
    store.commit();
  }
  TemporaryDirectory directory{Medium::kMemory};
  std::filesystem::path path = directory.path() / "s.plait";
};

}  // namespace

TEST_CASE("Stencil_AnyEdge_IsTheNaiveSet") {
  for (const NamedMesh& named : all_meshes()) {
    const BaseMesh mesh = BaseMesh::build(named.mesh);
    for (const Reach reach : {Reach::kOwn, Reach::kFaces, Reach::kRing}) {
      const auto expected = naive_reach(mesh, reach);
      INFO(named.name << ", reach " << static_cast<int>(reach));
      for (EdgeId edge = 0; edge < mesh.edge_count(); ++edge) {
        std::set<EdgeId> found;
        for_each_edge_in_reach(mesh.topology(), edge, reach,
                               [&](EdgeId visited) { found.insert(visited); });
        REQUIRE(found == expected[edge]);
      }
    }
  }
}

TEST_CASE("Sweep_AnyNumberOfThreads_CallsTheKernelOncePerEdge", "[threads]") {
  for (const IndexedMesh& mesh : {tetrahedron(), single_triangle(), torus_grid(40, 50)})
    for (const int threads : {1, 2, 5}) {
      Store store = sweep_in_memory(mesh);
      const AttributeId id = add_sample(store, sample_schemas()[0], 2);
      std::vector<std::atomic<int>> calls(store.base().edge_count());
      std::atomic<bool> right_worker = true;
      SweepPass pass;
      pass.accesses = {{id, 1, 2, Access::kRead, Reach::kFaces}};
      pass.kernel = [&](const SweepView&, EdgeId edge, int worker) {
        ++calls[edge];
        if (worker < 0 || worker >= threads) right_worker = false;
      };
      std::uint64_t last = 0, total = 0;
      sweep(store, pass, {threads, [&](const Progress& now) {
                            CHECK(now.done > last);
                            last = now.done;
                            total = now.total;
                            return true;
                          }});
      CHECK(std::ranges::all_of(calls, [](const std::atomic<int>& count) { return count == 1; }));
      CHECK(right_worker);
      CHECK(last == store.base().edge_count());
      CHECK(total == store.base().edge_count());
    }
}

TEST_CASE("Sweep_NoAccesses_StillVisitsEveryEdge") {
  Store store = sweep_in_memory(torus_grid(40, 50));
  std::uint64_t calls = 0;
  const SweepPass pass{.kernel = [&](const SweepView&, EdgeId, int) { ++calls; }};
  CHECK(sweep_window_bytes(store, pass) == 0);
  sweep(store, pass, {});
  CHECK(calls == store.base().edge_count());
}

TEST_CASE("Sweep_WritesOfOneEdge_AreInItsSlotAndNowhereElse", "[threads]") {
  for (const std::string& backend : durable_backends())
    for (const int threads : {1, 2}) {
      INFO(backend << ", threads " << threads);
      const SweptOnDisk place(backend, sheet(18, 20), 3);
      {
        Store store = Store::open(place.path, {.writable = true, .budget_bytes = 1 << 20},
                                  default_backends());
        SweepPass pass;
        pass.accesses = {{0, 2, 3, Access::kOverwrite, Reach::kOwn}};
        pass.kernel = [&](const SweepView& view, EdgeId edge, int) {
          if (edge % 3 != 0) {  // kOverwrite promises all of it
            for (const int level : {2, 3})
              std::ranges::fill(view.slot(0, level, edge).bytes, std::byte{0});
            return;
          }
          for (const int level : {2, 3})
            for (Vector3<float>& record : view.records<Vector3<float>>(0, level, edge))
              record = {static_cast<float>(edge), static_cast<float>(level), 1};
        };
        sweep(store, pass, {threads, {}});
        store.commit();
      }
      Store store =
          Store::open(place.path, {.writable = false, .budget_bytes = 1 << 20}, default_backends());
      CHECK(read_level(store, 0, 1) == sample_level(store, sample_schemas()[0], 1));
      for (const int level : {2, 3}) {
        const std::vector<std::byte> bytes = read_level(store, 0, level);
        const LevelGeometry& geometry = StoreAccess::level_file(store, 0, level).geometry;
        bool right = true;
        for (EdgeId edge = 0; edge < store.base().edge_count(); ++edge)
          for (std::uint64_t at = 0; at < geometry.slot(edge).bytes; at += 12) {
            Vector3<float> found;
            std::memcpy(&found, &bytes[geometry.slot(edge).offset + at], 12);
            right &= edge % 3 != 0 ? found == Vector3<float>{0, 0, 0}
                                   : found == Vector3<float>{static_cast<float>(edge),
                                                             static_cast<float>(level), 1};
          }
        CHECK(right);
      }
    }
}

TEST_CASE("Sweep_UpdateAccess_ReadsAndWritesEverySlotOnce") {
  for (const std::string& backend : durable_backends()) {
    const SweptOnDisk place(backend, sheet(18, 20), 3);
    {
      Store store =
          Store::open(place.path, {.writable = true, .budget_bytes = 64 << 10}, default_backends());
      SweepPass pass;
      pass.accesses = {{0, 1, 3, Access::kUpdate, Reach::kOwn}};
      pass.kernel = [](const SweepView& view, EdgeId edge, int) {
        for (int level = 1; level <= 3; ++level)
          for (std::byte& byte : view.slot(0, level, edge).bytes) byte ^= std::byte{0x5a};
      };
      sweep(store, pass, {2, {}});
      store.commit();
    }
    Store store = Store::open(place.path, {}, default_backends());
    for (int level = 1; level <= 3; ++level) {
      std::vector<std::byte> expected = sample_level(store, sample_schemas()[0], level);
      for (std::byte& byte : expected) byte ^= std::byte{0x5a};
      CHECK(read_level(store, 0, level) == expected);
    }
  }
}

TEST_CASE("Sweep_WriteOnlyLevels_AreNeverRead") {
  for (const std::string& backend : durable_backends()) {
    const SweptOnDisk place(backend, torus_grid(20, 30), 3);
    BackendCounts counts;
    const BackendRegistry counting = counting_registry(default_backends(), counts);
    Store store = Store::open(place.path, {.writable = true, .budget_bytes = 64 << 10}, counting);
    SweepPass pass;
    pass.accesses = {{0, 1, 3, Access::kOverwrite, Reach::kOwn}};
    pass.kernel = [](const SweepView& view, EdgeId edge, int) {
      for (int level = 1; level <= 3; ++level)
        std::ranges::fill(view.slot(0, level, edge).bytes, std::byte{1});
    };
    sweep(store, pass, {});
    store.commit();
    std::uint64_t blocks = 0;
    for (int level = 1; level <= 3; ++level)
      blocks += StoreAccess::level_file(store, 0, level).geometry.block_count();
    CHECK(counts.read_calls == 0);
    CHECK(store.info().paging.blocks_read == 0);
    CHECK(store.info().paging.blocks_written == blocks);
    CHECK(store.info().paging.blocks_prefetched == 0);
  }
}

TEST_CASE("Sweep_AmpleBudget_ReadsEveryBlockOnce") {
  for (const std::string& backend : durable_backends()) {
    const SweptOnDisk place(backend, torus_grid(20, 30), 3);
    Store store =
        Store::open(place.path, {.writable = false, .budget_bytes = 16 << 20}, default_backends());
    const SweepPass pass{.accesses = {{0, 2, 3, Access::kRead, Reach::kRing}},
                         .kernel = [](const SweepView&, EdgeId, int) {}};
    sweep(store, pass, {});
    const std::uint64_t blocks = StoreAccess::level_file(store, 0, 2).geometry.block_count() +
                                 StoreAccess::level_file(store, 0, 3).geometry.block_count();
    REQUIRE(blocks > 50);
    CHECK(store.info().paging.blocks_read == blocks);
    CHECK(store.info().paging.blocks_written == 0);
  }
}

TEST_CASE("Sweep_SeveralAttributesAndLevels_SeesEachByItsNumber") {
  Store store = sweep_in_memory(random_sheet(7, 100), 2);  // levels 3, 4, ... have slots
  std::vector<AttributeId> ids;
  for (const AttributeSchema& schema : sample_schemas())
    ids.push_back(add_sample(store, schema, 3));
  SweepPass pass;
  pass.accesses = {{ids[4], 3, 3, Access::kRead, Reach::kOwn},
                   {ids[0], 1, 0, Access::kRead, Reach::kOwn},  // no level
                   {ids[1], 4, 5, Access::kRead, Reach::kFaces},
                   {ids[5], 5, 5, Access::kRead, Reach::kOwn}};
  std::atomic<bool> right = true;
  const auto check = [&](const SweepView& view, std::size_t access, int level, EdgeId edge) {
    const AttributeSchema& schema = store.attributes()[pass.accesses[access].attribute].schema;
    const std::span<std::byte> slot = view.slot(access, level, edge).bytes;
    const Edge& ends = store.base().edges()[edge];
    const std::size_t n = std::size_t{1} << (level - 3);
    const std::size_t records = ends.is_border() ? n * (n + 1) / 2 : n * n;
    if (slot.size() != records * schema.record_bytes() ||
        !std::ranges::equal(slot, sample_slot(schema, level, ends.start, ends.end, slot.size())))
      right = false;
  };
  pass.kernel = [&](const SweepView& view, EdgeId edge, int) {
    check(view, 0, 3, edge);
    check(view, 2, 4, edge);
    check(view, 2, 5, edge);
    check(view, 3, 5, edge);
  };
  sweep(store, pass, {2, {}});
  CHECK(right);
}

TEST_CASE("Sweep_RecordTypeOfTheProgramsOwn_IsReadAndWritten") {
  Store store = sweep_in_memory(random_sheet(7, 100));
  const AttributeId id = store.add_attribute(schema_of<Spin>("spin"));
  CHECK(store.attributes()[id].schema == AttributeSchema{"spin", ComponentType::kInt16, 4});
  for (Spin& spin : store.base_records<Spin>(id)) spin = {{1, 2, 3, 4}};
  store.add_level(id);
  store.add_level(id);
  SweepPass pass;
  pass.accesses = {{id, 1, 2, Access::kOverwrite, Reach::kOwn}};
  pass.kernel = [](const SweepView& view, EdgeId edge, int) {
    for (const int level : {1, 2})
      for (Spin& spin : view.records<Spin>(0, level, edge))
        spin = {{static_cast<std::int16_t>(edge), -1, static_cast<std::int16_t>(level), -2}};
  };
  sweep(store, pass, {});
  std::uint64_t records = 0;
  bool right = true;
  pass.accesses[0].access = Access::kRead;
  pass.kernel = [&](const SweepView& view, EdgeId edge, int) {
    for (const int level : {1, 2})
      for (const Spin& spin : view.records<Spin>(0, level, edge)) {
        ++records;
        right &= spin.parts[0] == static_cast<std::int16_t>(edge) && spin.parts[1] == -1 &&
                 spin.parts[2] == level && spin.parts[3] == -2;
      }
  };
  sweep(store, pass, {});
  CHECK(right);
  CHECK(records + store.base().vertex_count() == counts_at_level(store.base(), 2).vertices);
}

TEST_CASE("Sweep_Cancelled_StopsBetweenBlocksAndLeavesTheStoreUsable") {
  const SweptOnDisk place("pread", torus_grid(20, 30), 3);
  Store store =
      Store::open(place.path, {.writable = false, .budget_bytes = 1 << 20}, default_backends());
  std::uint64_t calls = 0, reported = 0;
  const SweepPass pass{.name = "count",
                       .accesses = {{0, 1, 3, Access::kRead, Reach::kFaces}},
                       .kernel = [&](const SweepView&, EdgeId, int) { ++calls; }};
  const Error error = error_of([&] {
    sweep(store, pass, {1, [&](const Progress& now) {
                          reported = now.done;
                          return calls < 100;
                        }});
  });
  CHECK(error.code() == ErrorCode::kCancelled);
  CHECK(names(error, {"'count'"}));
  CHECK(calls == reported);
  CHECK(calls >= 100);
  CHECK(calls < store.base().edge_count());
  calls = 0;
  sweep(store, pass, {});
  CHECK(calls == store.base().edge_count());
}

TEST_CASE("Sweep_DamagedBlock_ThrowsCorruptionAndLeavesTheStoreUsable") {
  for (const std::string& backend : durable_backends()) {
    const SweptOnDisk place(backend, torus_grid(20, 30), 3);
    Store store =
        Store::open(place.path, {.writable = false, .budget_bytes = 1 << 20}, default_backends());
    const LevelFile& file = StoreAccess::level_file(store, 0, 3);
    const std::uint64_t offset = file.table[20].offset + 5;
    overwrite_byte(file.path, offset, file_bytes(file.path)[offset] ^ std::byte{1});
    std::vector<int> calls(store.base().edge_count());
    SweepPass pass{.accesses = {{0, 3, 3, Access::kRead, Reach::kOwn}},
                   .kernel = [&](const SweepView&, EdgeId edge, int) { ++calls[edge]; }};
    const Error error = error_of([&] { sweep(store, pass, {}); });
    CHECK(error.code() == ErrorCode::kCorruption);
    CHECK(names(error, {file.path.string(), "block 20"}));
    CHECK(std::all_of(calls.begin() + file.geometry.first_edge(20), calls.end(),
                      [](int count) { return count == 0; }));
    pass.accesses = {{0, 1, 2, Access::kRead, Reach::kOwn}};
    sweep(store, pass, {});
  }
}

TEST_CASE("Sweep_OptionsOrAccessesOutOfRange_AreRefused") {
  Store store = sweep_in_memory(tetrahedron());
  const AttributeId id = add_sample(store, sample_schemas()[0], 1);
  SweepPass pass{.name = "wrong",
                 .accesses = {{id, 1, 1, Access::kRead, Reach::kFaces}},
                 .kernel = [](const SweepView&, EdgeId, int) { FAIL("the kernel was called"); }};
  const auto refused = [&](int threads, const char* word) {
    const Error error = error_of([&] { sweep(store, pass, {threads, {}}); });
    CHECK(error.code() == ErrorCode::kInvalidArgument);
    CHECK(names(error, {"'wrong'", word}));
  };
  for (const int threads : {-1, 1025}) refused(threads, "threads");
  for (const Access access : {Access::kOverwrite, Access::kUpdate})
    for (const Reach reach : {Reach::kFaces, Reach::kRing}) {
      pass.accesses[0].access = access;
      pass.accesses[0].reach = reach;
      refused(1, "beyond");
    }
}

TEST_CASE("Sweep_LevelOrAttributeThatIsNotThere_IsRefused") {
  Store store = sweep_in_memory(tetrahedron(), 1);
  add_sample(store, sample_schemas()[0], 1);
  const auto refused = [&](AttributeId attribute, int first, int last) {
    const SweepPass pass{
        .name = "wrong",
        .accesses = {{attribute, first, last, Access::kRead, Reach::kOwn}},
        .kernel = [](const SweepView&, EdgeId, int) { FAIL("the kernel was called"); }};
    const Error error = error_of([&] { sweep(store, pass, {}); });
    CHECK(error.code() == ErrorCode::kInvalidArgument);
    CHECK(names(error, {"'wrong'", "no levels"}));
    CHECK(error_of([&] { sweep_window_bytes(store, pass); }).code() == ErrorCode::kInvalidArgument);
  };
  refused(1, 2, 2);
  refused(0, 1, 2);  // level 1 is the base mesh
  refused(0, 2, 3);
  refused(0, -1, 2);
}

TEST_CASE("Sweep_WritesToAStoreOpenedForReading_AreRefused") {
  for (const std::string& backend : durable_backends()) {
    const SweptOnDisk place(backend, tetrahedron(), 1);
    Store store = Store::open(place.path, {}, default_backends());
    SweepPass pass{.kernel = [](const SweepView&, EdgeId, int) { FAIL("the kernel was called"); }};
    for (const Access access : {Access::kOverwrite, Access::kUpdate}) {
      pass.accesses = {{0, 1, 1, access, Reach::kOwn}};
      const Error error = error_of([&] { sweep(store, pass, {}); });
      CHECK(error.code() == ErrorCode::kBadState);
      CHECK(names(error, {place.path.string(), "opened for reading"}));
    }
  }
}

TEST_CASE("Sweep_KernelThatThrows_EndsTheCallAndLeavesTheLevelUnfinished", "[threads]") {
  for (const char* backend : {"memory", "pread"})
    for (const int threads : {1, 2}) {
      CAPTURE(backend, threads);
      const TemporaryDirectory directory;
      const bool on_disk = std::string(backend) != "memory";
      Store store = Store::create(on_disk ? directory.path() / "s.plait" : std::filesystem::path(),
                                  BaseMesh::build(random_sheet(5, 60)), sample_options(backend),
                                  default_backends());
      add_sample(store, sample_schemas()[0], 3);
      store.commit();
      SweepPass pass;
      pass.accesses = {{0, 2, 2, Access::kUpdate, Reach::kOwn}};
      pass.kernel = [&](const SweepView&, EdgeId edge, int) {
        if (edge == 40) throw std::string("of the program's own");
      };
      CHECK_THROWS_AS(sweep(store, pass, {.threads = threads}), std::string);
      CHECK_FALSE(StoreAccess::level_file(store, 0, 2).is_finished());
      CHECK(error_of([&] { store.commit(); }).code() == ErrorCode::kBadState);
      store.roll_back();
      CHECK(holds_sample(store, 0));
    }
}

TEST_CASE("Sweep_OfAConstStore_ReadsAndRefusesToWrite", "[threads]") {
  Store store = sweep_in_memory(random_sheet(5, 60));
  add_sample(store, sample_schemas()[0], 2);
  const Store& reading = store;
  SweepPass pass{.accesses = {{0, 1, 2, Access::kRead, Reach::kOwn}}};
  std::atomic<int> edges = 0;
  pass.kernel = [&](const SweepView&, EdgeId, int) { ++edges; };
  sweep(reading, pass, {.threads = 0});
  CHECK(edges == static_cast<int>(store.base().edge_count()));
  pass.accesses[0].access = Access::kUpdate;
  CHECK(error_of([&] { sweep(reading, pass, {}); }).code() == ErrorCode::kInvalidArgument);
}
