// Threads that share one Reader while another process commits: each patch is of the version that
// the store has opened. The thread sanitizer sees all threads of the readers.
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <filesystem>
#include <random>
#include <thread>
#include <vector>

#include "engine/store/sample_store.h"
#include "plait/extend/store_access.h"
#include "plait/reader.h"
#include "plait/registry.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

namespace fs = std::filesystem;
using Point = Vector3<float>;

constexpr std::uint64_t kPatchVersions = 30;
constexpr int kPatchLevels = 3, kThreads = 3;

/// In version n, every coordinate of every vertex is n.
void fill_patches(Store& store) {
  const auto value = static_cast<float>(store.sequence() + 1);
  const Point point{value, value, value};
  std::ranges::fill(store.base_records<Point>(0), point);
  for (int level = 1; level <= kPatchLevels; ++level) {
    LevelFile& file = StoreAccess::level_file(store, 0, level);
    for (std::uint64_t block = 0; block < file.geometry.block_count(); ++block) {
      const PinnedBlock pinned =
          StoreAccess::open_session(store).pin(file, block, Access::kOverwrite);
      auto* const points = reinterpret_cast<Point*>(pinned.bytes().data());
      std::fill(points, points + pinned.bytes().size() / sizeof(Point), point);
    }
  }
}

Store open_patches(const fs::path& path, bool writable) {
  OpenOptions options;
  options.writable = writable;
  options.budget_bytes = writable ? 128 << 10 : 1 << 20;
  options.durability = Durability::kNone;
  return Store::open(path, options, default_backends());
}

void make_patch_store(const fs::path& path, const std::string& backend) {
  Store store = Store::create(path, BaseMesh::build(torus_grid(6, 6)), sample_options(backend),
                              default_backends());
  store.add_attribute(schema_of<Point>("position"));
  for (int level = 0; level < kPatchLevels; ++level) store.add_level(0);
  fill_patches(store);
  store.commit();
}

pid_t start_writer(const fs::path& path) {
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child > 0) return child;
  try {
    Store store = open_patches(path, true);
    while (store.sequence() < kPatchVersions) {
      fill_patches(store);
      store.commit();
    }
    store.close();
    ::_exit(0);
  } catch (const std::exception&) {
    ::_exit(1);
  }
}

std::uint64_t wrong_points(const Reader& reader, FaceId face, float expected) {
  std::vector<Point> points(patch_vertex_count(1 << kPatchLevels));
  reader.read_patch(face, kPatchLevels).attribute<Point>("position").copy_to(points);
  return static_cast<std::uint64_t>(std::ranges::count_if(points, [&](const Point& point) {
    return point != Point{expected, expected, expected};
  }));
}

}  // namespace

TEST_CASE("Reader_ThreadsBesideAWriterProcess_ReadTheVersionOfTheirStore") {
  const auto backend = GENERATE(as<std::string>(), "pread", "mmap", "uring", "compressed");
  const TemporaryDirectory here(Medium::kMemory);
  const fs::path path = here.path() / "s.plait";
  make_patch_store(path, backend);
  const pid_t writer = start_writer(path);
  std::atomic<std::uint64_t> wrong = 0, versions = 0;
  bool last = false;
  do {
    int status = 0;
    last = ::waitpid(writer, &status, WNOHANG) == writer;
    if (last) CHECK((WIFEXITED(status) && WEXITSTATUS(status) == 0));
    const Store store = open_patches(path, false);
    if (last) CHECK(store.sequence() == kPatchVersions);
    const Reader reader(store);
    const auto expected = static_cast<float>(store.sequence());
    std::vector<std::thread> threads;
    for (unsigned number = 0; number < kThreads; ++number)
      threads.emplace_back([&, number] {
        std::mt19937 random(number);
        for (int count = 0; count < 20; ++count)
          wrong += wrong_points(reader, static_cast<FaceId>(random() % 72), expected);
        const double at = expected;
        wrong += reader.faces_in_box({{at, at, at}, {at, at, at}}).size() != 72;
        wrong += !reader.faces_in_box({{at + 1, 0, 0}, {at + 1, at, at}}).empty();
      });
    for (std::thread& thread : threads) thread.join();
    ++versions;
  } while (!last);
  CHECK(wrong == 0);
  CHECK(versions > 0);
}

}  // namespace plait::test
