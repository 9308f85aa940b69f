// One writer and many readers, each opening the store again and again: nobody ever sees a mixture
// of two versions, and nobody is kept out for good.
//
// PLAIT_LONG=1 in the environment writes 75 times as many versions.
#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "durability/faults.h"
#include "durability/workload.h"
#include "engine/store/sample_store.h"
#include "plait/extend/store_access.h"
#include "plait/registry.h"
#include "support/eventually.h"
#include "support/temporary_directory.h"

namespace plait::test {
namespace {

constexpr int kLevels = 3;
constexpr std::uint64_t kSoakBudgetBytes = 64 << 10;

std::uint64_t versions_to_write() { return std::getenv("PLAIT_LONG") ? 7500 : 100; }

std::optional<Store> try_open(const std::filesystem::path& path, bool writable) {
  try {
    return Store::open(path, {.writable = writable, .budget_bytes = kSoakBudgetBytes},
                       default_backends());
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kBusy) throw;
    return {};
  }
}

void fill_soak(Store& store, std::byte value) {
  for (std::byte& byte : store.base_bytes(0)) byte = value;
  for (int level = 1; level <= kLevels; ++level) {
    LevelFile& file = StoreAccess::level_file(store, 0, level);
    Session session = StoreAccess::open_session(store);
    for (std::uint64_t block = 0; block < file.geometry.block_count(); ++block) {
      const PinnedBlock pinned = session.pin(file, block, Access::kOverwrite);
      std::ranges::fill(pinned.bytes(), value);
    }
  }
}

/// Whether every byte of the store is its version's number.
bool is_one_version(Store& store) {
  const auto expected = static_cast<std::byte>(store.sequence());
  const auto is_expected = [&](std::byte byte) { return byte == expected; };
  if (!std::ranges::all_of(std::as_const(store).base_bytes(0), is_expected)) return false;
  for (int level = 1; level <= kLevels; ++level)
    if (!std::ranges::all_of(read_level(store, 0, level), is_expected)) return false;
  return true;
}

}  // namespace

TEST_CASE("WriterAndReaders_ForManyVersions_EachSeeOneVersionWhole") {
  for (const std::string& backend : durable_backends()) {
    CAPTURE(backend);
    const NoWaiting no_waiting;
    const TemporaryDirectory here;
    const std::filesystem::path path = here.path() / "s.plait";
    {
      Store store = create_store(path, backend);
      store.add_attribute({"value", ComponentType::kUint8, 12});
      for (int level = 0; level < kLevels; ++level) store.add_level(0);
      fill_soak(store, std::byte{1});
      store.commit();
    }
    std::atomic<bool> end = false;
    std::atomic<std::uint64_t> mixtures = 0, reads = 0, writes = 0, given_up = 0;
    std::mutex mutex;
    std::string errors;
    const auto whenever_possible = [&](auto work) {
      return std::thread([&, work] {
        while (!end) {
          try {
            work();
          } catch (const std::exception& error) {
            const std::scoped_lock lock(mutex);
            errors += std::string(error.what()) + "\n";
          }
          std::this_thread::yield();
        }
      });
    };
    std::vector<std::thread> threads;
    threads.reserve(3);
    for (int reader = 0; reader < 2; ++reader)
      threads.push_back(whenever_possible([&] {
        std::optional<Store> store = try_open(path, false);
        if (!store) return;
        if (!is_one_version(*store)) ++mixtures;
        ++reads;
        // Nobody reads until there is another version, so that the writer has its turn.
        store.reset();
        const std::uint64_t written = writes;
        eventually([&] { return end || writes != written; });
      }));
    threads.push_back(whenever_possible([&] {
      std::optional<Store> store = try_open(path, true);
      if (!store) return;
      if (!is_one_version(*store)) ++mixtures;
      fill_soak(*store, static_cast<std::byte>(store->sequence() + 1));
      // What is not committed must be undone by whoever opens the store next.
      if (writes % 3 == 2) {
        StoreAccess::pager(*store).flush();
        ++given_up;
      } else {
        store->commit();
      }
      ++writes;
    }));
    CHECK(eventually([&] { return writes >= versions_to_write() && reads > 0; }));
    end = true;
    for (std::thread& thread : threads) thread.join();
    CAPTURE(errors);
    CHECK(errors.empty());
    CHECK(mixtures == 0);
    CHECK(reads > 0);
    CHECK(writes > 0);
    CHECK(Store::open(path, {}, default_backends()).sequence() == 1 + writes - given_up);
  }
}

}  // namespace plait::test
