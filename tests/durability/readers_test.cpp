// Readers that live beside a writer: each sees exactly one version for as long as it has the store
// open, whatever is committed meanwhile, and none ever waits or is turned away. PLAIT_LONG=1 in the
// environment commits 1,000 times.
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "durability/faults.h"
#include "durability/workload.h"
#include "engine/store/sample_store.h"
#include "format/file_names.h"
#include "format/manifest.h"
#include "plait/extend/store_access.h"
#include "plait/registry.h"
#include "support/computing.h"
#include "support/sanitized.h"
#include "support/temporary_directory.h"

namespace plait::test {
namespace {

namespace fs = std::filesystem;

const std::uint64_t kVersions = std::getenv("PLAIT_LONG") ? 1000u : unless_sanitized(100u, 40u);
constexpr std::uint64_t kReadersBudgetBytes = 256 << 10;
/// Levels are appended at these versions.
const std::uint64_t kAppendedAt[] = {kVersions / 4, kVersions / 2};

std::byte value_of(std::uint64_t version) { return static_cast<std::byte>(version % 251 + 1); }

Store open(const fs::path& path, bool writable = false) {
  return Store::open(path,
                     {.writable = writable, .budget_bytes = kReadersBudgetBytes, .io_threads = 0},
                     default_backends());
}

/// Every record of the store becomes the number of the version that is about to be committed.
void fill(Store& store) {
  const std::byte value = value_of(store.sequence() + 1);
  for (std::byte& byte : store.base_bytes(0)) byte = value;
  for (int level = 1; level <= store.finest_level(); ++level) {
    LevelFile& file = StoreAccess::level_file(store, 0, level);
    for (std::uint64_t block = 0; block < file.geometry.block_count(); ++block)
      std::ranges::fill(
          StoreAccess::open_session(store).pin(file, block, Access::kOverwrite).bytes(), value);
  }
}

void make_store(const fs::path& path, const std::string& backend) {
  Store store = create_store(path, backend);
  store.add_attribute({"value", ComponentType::kUint8, 12});
  for (int level = 0; level < 2; ++level) store.add_level(0);
  fill(store);
  store.commit();
}

/// What is wrong with a store that should hold the version that it says; empty if nothing is.
std::string fault_of(Store& store) {
  const std::byte expected = value_of(store.sequence());
  const auto is_expected = [&](std::byte byte) { return byte == expected; };
  if (!std::ranges::all_of(std::as_const(store).base_bytes(0), is_expected)) return "base records";
  const int levels = 2 + static_cast<int>(std::ranges::count_if(
                             kAppendedAt, [&](auto at) { return at <= store.sequence(); }));
  if (store.finest_level() != levels) return "number of levels";
  for (int level = 1; level <= levels; ++level)
    if (!std::ranges::all_of(read_level(store, 0, level), is_expected)) return "a level";
  return "";
}

/// Commits until the store has `kVersions` versions. After each eighth one comes another writer,
/// which undoes what this one has written since.
void write_versions(const fs::path& path) {
  while (true) {
    Store store = open(path, true);
    while (store.sequence() < kVersions) {
      if (std::ranges::find(kAppendedAt, store.sequence() + 1) != std::end(kAppendedAt))
        store.add_level(0);
      fill(store);
      store.commit();
      // Readers have their turn meanwhile.
      if (const std::string fault = fault_of(store); !fault.empty())
        throw Error(ErrorCode::kBadState, fault);
      if (store.sequence() % 8 == 0) break;
    }
    if (store.sequence() == kVersions) return;
    fill(store);
    StoreAccess::pager(store).flush();
  }
}

/// Opens the store once and reads it several times while others commit. Throws what opening throws.
std::string read_once(const fs::path& path, std::mt19937& random) {
  Store store = open(path);
  const std::uint64_t version = store.sequence();
  for (auto round = random() % 4;; --round) {
    if (const std::string fault = fault_of(store); !fault.empty()) return fault;
    if (store.sequence() != version) return "another version";
    if (round == 0) return "";
    // Others may commit a version; the last one stays the newest.
    for (auto looks = random() % 20; looks > 0 && open(path).sequence() == version; --looks)
      std::this_thread::yield();
  }
}

/// In a process of its own, which ends by _exit: 0, or 1 after an error, which it prints.
template <class Work>
pid_t in_process(Work work) {
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child > 0) return child;
  int status = 1;
  try {
    const NoWaiting no_waiting;
    work();
    status = 0;
  } catch (const std::exception& error) {
    const std::string line = std::string(error.what()) + "\n";
    if (::write(2, line.data(), line.size()) < 0) status = 2;
  }
  ::_exit(status);
}

/// Whether the process ended well; `killed`: it may also have been killed.
bool ended_well(pid_t child, bool killed) {
  int status = 0;
  ::waitpid(child, &status, 0);
  return (WIFEXITED(status) && WEXITSTATUS(status) == 0) ||
         (killed && WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL);
}

/// The store has its last version, and after another writer no file of an older one.
void check_end(const fs::path& path) {
  {
    Store store = open(path);
    CHECK(store.sequence() == kVersions);
    CHECK(fault_of(store).empty());
  }
  open(path, true).close();
  std::set<std::string> expected = {"base.mesh", "lock", "manifest"};
  const Directory directory(path);
  for (const Manifest& slot : read_whole_slots(File(directory, kManifestName, OpenMode::kRead)))
    for (const char* prefix : {"version.", "attribute0.base."})
      expected.insert(prefix + std::to_string(slot.described));
  if (const LogPlace log = read_manifest(directory).log; log.generation != 0)
    expected.insert(change_log_name(log.generation));
  std::set<std::string> found = file_names(path);
  CHECK(std::erase_if(found, [](const std::string& name) {
          return name.find(".level") != std::string::npos;
        }) == 4);
  CHECK(found == expected);
}

}  // namespace

TEST_CASE("Readers_ThreadsBesideAWriter_EachSeeOneVersionAndNeverWait", "[threads]") {
  for (const std::string& backend : durable_backends()) {
    CAPTURE(backend);
    const NoWaiting no_waiting;
    const TemporaryDirectory here(Medium::kMemory);
    const fs::path path = here.path() / "s.plait";
    make_store(path, backend);
    std::atomic<bool> end = false;
    std::atomic<std::uint64_t> reads = 0;
    std::mutex mutex;
    std::string faults;
    std::vector<std::thread> readers;
    for (std::uint32_t number = 0; number < 3; ++number)
      readers.emplace_back([&, number] {
        std::mt19937 random(number);
        while (!end) {
          std::string fault;
          try {
            fault = read_once(path, random);
            ++reads;
          } catch (const std::exception& error) {
            fault = error.what();
          }
          const std::scoped_lock lock(mutex);
          if (!fault.empty()) faults += fault + "\n";
        }
      });
    CHECK_NOTHROW(write_versions(path));
    // On a busy machine the readers may not have had their turns yet.
    const auto have_read = [&] {
      const std::scoped_lock lock(mutex);
      return reads > 10 || !faults.empty();
    };
    while (!have_read()) std::this_thread::yield();
    end = true;
    for (std::thread& reader : readers) reader.join();
    CAPTURE(faults);
    CHECK(faults.empty());
    CHECK(reads > 10);
    check_end(path);
  }
}

TEST_CASE("Readers_ProcessesKilledAtRandomBesideAWriterThatIsToo_EachSeeOneVersion") {
  for (const std::string& backend : durable_backends()) {
    CAPTURE(backend);
    const TemporaryDirectory here(Medium::kMemory);
    const fs::path path = here.path() / "s.plait";
    {
      const NoWaiting no_waiting;
      make_store(path, backend);
    }
    std::mt19937 random(5);
    const auto start_reader = [&](std::uint32_t seed) {
      return in_process([&, seed] {
        std::mt19937 own(seed);
        while (true)
          if (const std::string fault = read_once(path, own); !fault.empty())
            throw Error(ErrorCode::kBadState, fault);
      });
    };
    std::vector<pid_t> readers;
    for (std::uint32_t number = 0; number < 3; ++number) readers.push_back(start_reader(number));
    const auto replace_a_reader = [&] {
      pid_t& reader = readers[random() % readers.size()];
      ::kill(reader, SIGKILL);
      CHECK(ended_well(reader, true));
      reader = start_reader(static_cast<std::uint32_t>(random()));
    };
    for (bool finished = false; !finished;) {
      const pid_t writer = in_process([&] { write_versions(path); });
      const bool kill = random() % 3 != 0;
      int status = 0;
      for (auto rest = kill ? random() % 20 : ~0ul; rest > 0; --rest) {
        computes_for(writer, std::chrono::milliseconds(5));
        finished = ::waitpid(writer, &status, WNOHANG) == writer;
        if (finished) break;
        if (random() % 8 == 0) replace_a_reader();
      }
      if (finished) {
        CHECK((WIFEXITED(status) && WEXITSTATUS(status) == 0));
      } else {
        ::kill(writer, SIGKILL);
        CHECK(ended_well(writer, true));
      }
    }
    for (const pid_t reader : readers) {
      ::kill(reader, SIGKILL);
      CHECK(ended_well(reader, true));
    }
    check_end(path);
  }
}

}  // namespace plait::test
