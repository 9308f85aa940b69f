// Patches that a program reads ahead, and what a store tells of evictions and slow reads.
#include <atomic>
#include <catch2/catch.hpp>
#include <mutex>
#include <numeric>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "engine/store/sample_store.h"
#include "plait/reader.h"
#include "plait/registry.h"
#include "plait/store_info.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

constexpr int kPatchLevels = 4;

void make(const std::filesystem::path& path, const std::string& backend) {
  Store store = Store::create(path, BaseMesh::build(random_sphere(3, 200)), sample_options(backend),
                              default_backends());
  add_sample(store, sample_schemas()[0], kPatchLevels);
  store.commit();
}

struct Told {
  StoreEvent::Kind kind;
  std::uint64_t version;
  std::string store, attribute;
  int level;
  std::uint64_t block, bytes;
};

/// Keeps what a store tells.
class Log {
 public:
  StoreEvents events(std::uint64_t slow_read_ns = 1'000'000'000'000) {
    return {
        [this](const StoreEvent& event) {
          const std::scoped_lock lock(mutex_);
          told_.push_back({event.kind, event.version, std::string(event.store),
                           std::string(event.attribute), event.level, event.block, event.bytes});
        },
        slow_read_ns};
  }
  std::vector<Told> of(StoreEvent::Kind kind) const {
    const std::scoped_lock lock(mutex_);
    std::vector<Told> result;
    for (const Told& told : told_)
      if (told.kind == kind) result.push_back(told);
    return result;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<Told> told_;
};

}  // namespace

TEST_CASE("Prefetch_PatchesReadLater_AreReadOnlyOnce") {
  const TemporaryDirectory directory;
  for (const char* backend : {"pread", "compressed"}) {
    CAPTURE(backend);
    const auto path = directory.path() / backend;
    make(path, backend);
    const Store store = Store::open(path, {}, default_backends());
    const Reader reader(store);
    std::vector<FaceId> faces(store.base().face_count());
    std::iota(faces.begin(), faces.end(), FaceId{0});
    std::size_t ahead = 0;
    for (std::size_t at = 0; at < faces.size(); ++at) {
      if (at >= ahead) {
        const std::size_t begun = reader.prefetch(std::span(faces).subspan(at), kPatchLevels);
        CHECK(begun <= 64);
        ahead = at + begun;
      }
      reader.read_patch(faces[at], kPatchLevels);
    }
    const PagingStatistics statistics = reader.statistics();
    CHECK(statistics.blocks_prefetched > 0);
    CHECK(statistics.blocks_evicted == 0);
    CHECK(statistics.blocks_read >= statistics.blocks_prefetched);
    const std::uint64_t once = statistics.blocks_read;
    for (const FaceId face : faces) reader.read_patch(face, kPatchLevels);
    CHECK(reader.statistics().blocks_read == once);
  }
}

TEST_CASE("Prefetch_FacesAndLevelsThatAreNotThere_ReadsNothing") {
  const TemporaryDirectory directory;
  const auto path = directory.path() / "s.plait";
  make(path, "pread");
  const Store store = Store::open(path, {}, default_backends());
  const Reader reader(store);
  CHECK(reader.prefetch(std::vector<FaceId>{1u << 30}, kPatchLevels) == 0);
  CHECK(reader.prefetch(std::vector<FaceId>{0}, kPatchLevels + 1) == 0);
  CHECK(reader.prefetch(std::vector<FaceId>{0}, -1) == 0);
  CHECK(reader.prefetch({}, kPatchLevels) == 0);
  CHECK(reader.statistics().blocks_prefetched == 0);
}

TEST_CASE("Prefetch_Ended_ItsBlocksMakeRoomForOthers") {
  const TemporaryDirectory directory;
  const auto path = directory.path() / "s.plait";
  make(path, "pread");
  const Store store = Store::open(path, {.budget_bytes = 64 << 10}, default_backends());
  const Reader reader(store);
  std::vector<FaceId> faces(store.base().face_count());
  std::iota(faces.begin(), faces.end(), FaceId{0});
  // Until the budget is full of blocks that nobody has read.
  const auto settle = [&] {
    while (true) {
      const PagingStatistics now = reader.statistics();
      if (now.blocks_read == now.blocks_prefetched) return now.blocks_prefetched;
      std::this_thread::yield();
    }
  };
  std::uint64_t before = 0;
  do {
    before = settle();
    reader.prefetch(faces, kPatchLevels);
  } while (settle() != before);
  const std::span<const FaceId> last = std::span(faces).last(20);
  reader.prefetch(last, kPatchLevels);
  CHECK(settle() == before);
  reader.end_prefetch();
  reader.prefetch(last, kPatchLevels);
  CHECK(settle() > before);
  reader.end_prefetch();
  reader.end_prefetch();
  for (auto face = faces.rbegin(); face != faces.rend(); ++face)
    REQUIRE(reader.read_patch(*face, kPatchLevels).face() == *face);
}

TEST_CASE("Events_OfAStore_TellOfOpenCommitAndEviction") {
  const TemporaryDirectory directory;
  const auto path = directory.path() / "s.plait";
  Log log;
  {
    StoreOptions options = sample_options("pread");
    options.budget_bytes = 64 << 10;
    options.events = log.events();
    Store store =
        Store::create(path, BaseMesh::build(random_sphere(3, 200)), options, default_backends());
    CHECK(log.of(StoreEvent::Kind::kOpened).size() == 1);
    add_sample(store, sample_schemas()[0], kPatchLevels);
    store.commit();
    store.commit();  // without a change
    REQUIRE(log.of(StoreEvent::Kind::kCommitted).size() == 1);
    CHECK(log.of(StoreEvent::Kind::kCommitted)[0].version == 1);
    CHECK(log.of(StoreEvent::Kind::kCommitted)[0].store == path.native());
  }
  Log later;
  const Store store =
      Store::open(path, {.budget_bytes = 64 << 10, .events = later.events()}, default_backends());
  REQUIRE(later.of(StoreEvent::Kind::kOpened).size() == 1);
  CHECK(later.of(StoreEvent::Kind::kOpened)[0].version == 1);
  const Reader reader(store);
  for (FaceId face = 0; face < store.base().face_count(); ++face)
    reader.read_patch(face, kPatchLevels);
  const std::vector<Told> evicted = later.of(StoreEvent::Kind::kEvicted);
  REQUIRE(evicted.size() > 10);
  CHECK(evicted.size() == store.info().paging.blocks_evicted);
  for (const Told& told : evicted) {
    REQUIRE(told.attribute == sample_schemas()[0].name);
    REQUIRE((told.level >= 1 && told.level <= kPatchLevels));
    REQUIRE((told.bytes > 0 && told.store == path.native()));
  }
  CHECK(later.of(StoreEvent::Kind::kSlowRead).empty());
}

TEST_CASE("Events_WithoutPatience_TellOfEachRead") {
  const TemporaryDirectory directory;
  const auto path = directory.path() / "s.plait";
  make(path, "pread");
  Log log;
  std::uint64_t reads = 0;
  {
    const Store store = Store::open(path, {.events = log.events(0)}, default_backends());
    const Reader reader(store);
    for (FaceId face = 0; face < store.base().face_count(); ++face)
      reader.read_patch(face, kPatchLevels);
    reads = store.info().paging.blocks_read;
  }
  CHECK(reads > 0);
  CHECK(log.of(StoreEvent::Kind::kSlowRead).size() == reads);
}

TEST_CASE("Events_CallThatThrowsOrTakesStatistics_HarmsNoRead") {
  const TemporaryDirectory directory;
  const auto path = directory.path() / "s.plait";
  make(path, "pread");
  const Store* open = nullptr;
  std::atomic<int> calls = 0;
  StoreEvents events{[&](const StoreEvent& event) {
                       ++calls;
                       if (open != nullptr)
                         CHECK(StoreAccess::pager(*open).statistics().blocks_read > 0);
                       if (event.kind != StoreEvent::Kind::kOpened) throw 1;
                     },
                     0};
  const OpenOptions options{.budget_bytes = 64 << 10, .io_threads = 0, .events = events};
  const Store store = Store::open(path, options, default_backends());
  open = &store;
  const Reader reader(store);
  for (FaceId face = 0; face < 50; ++face) reader.read_patch(face, kPatchLevels);
  CHECK(calls > 10);
}
