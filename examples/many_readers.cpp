// Four threads read patches of a store in any order while a writer commits new versions of it.
//
//   many_readers STORE        makes STORE, a directory, and leaves it there
//
// The octahedron |x| + |y| + |z| = 1 is refined into flat grids, and each version doubles all
// positions. So in version n every vertex has |x| + |y| + |z| = 2^(n - 1), without any rounding.
#include <atomic>
#include <cmath>
#include <cstdio>
#include <thread>
#include <vector>

#include "plait/create_store.h"
#include "plait/extend/sweep.h"
#include "plait/reader.h"
#include "plait/subdivide.h"

using Point = plait::Vector3<float>;

constexpr int kLevel = 4, kVersions = 20, kReaders = 4;

void make_store(const char* path) {
  const plait::BaseMesh octahedron = plait::BaseMesh::build(
      {.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
       .faces = {{0, 2, 4},
                 {2, 1, 4},
                 {1, 3, 4},
                 {3, 0, 4},
                 {2, 0, 5},
                 {1, 2, 5},
                 {3, 1, 5},
                 {0, 3, 5}}});
  plait::Store store = plait::create_store(path, octahedron);
  plait::subdivide(store, {.scheme = plait::Scheme::kMidpoint, .levels = kLevel});
  store.commit();
}

// Doubles the vertices of the base mesh, which are in memory, and by a sweep all others.
void double_positions(plait::Store& store) {
  const plait::AttributeId position = store.attribute("position");
  for (Point& point : store.base_records<Point>(position))
    point = {2 * point.x, 2 * point.y, 2 * point.z};
  plait::SweepPass pass;
  pass.name = "double";
  pass.accesses = {{position, 1, kLevel, plait::Access::kUpdate}};
  pass.kernel = [](const plait::SweepView& view, plait::EdgeId edge, int) {
    for (int level = 1; level <= kLevel; ++level) {
      const std::span<std::byte> slot = view.slot(0, level, edge).bytes;
      auto* const numbers = reinterpret_cast<float*>(slot.data());
      for (std::size_t i = 0; i < slot.size() / sizeof(float); ++i) numbers[i] *= 2;
    }
  };
  plait::sweep(store, pass, {});
}

// Reads patches from all over the mesh, and returns the number of vertices that are wrong.
std::uint64_t read_patches(const plait::Store& store, unsigned seed) {
  const float expected = std::ldexp(1.0f, static_cast<int>(store.sequence()) - 1);
  const plait::Reader reader(store, {.attributes = {"position"}});
  std::vector<Point> points(plait::patch_vertex_count(std::int64_t{1} << kLevel));
  std::uint64_t wrong = 0;
  for (unsigned count = 0; count < 50; ++count) {
    const auto face = static_cast<plait::FaceId>((seed + 3 * count) % store.base().face_count());
    reader.read_patch(face, kLevel).attribute<Point>("position").copy_to(points);
    for (const Point& at : points)
      wrong += std::abs(at.x) + std::abs(at.y) + std::abs(at.z) != expected;
  }
  return wrong;
}

int main(int count, char** words) try {
  if (count != 2) return std::fprintf(stderr, "usage: many_readers STORE\n"), 2;
  make_store(words[1]);
  std::atomic<bool> done = false;
  std::atomic<std::uint64_t> wrong = 0;
  std::vector<std::thread> readers;
  for (unsigned number = 0; number < kReaders; ++number)
    readers.emplace_back([&, number] {
      for (bool last = false; !last;) {
        last = done;  // once more after the last commit
        wrong += read_patches(plait::open_store(words[1]), number);
      }
    });
  plait::Store store = plait::open_store(words[1], {.writable = true});
  while (store.sequence() < kVersions) {
    double_positions(store);
    store.commit();
  }
  done = true;
  for (std::thread& reader : readers) reader.join();
  std::printf("%d versions, %llu wrong vertices\n", kVersions,
              static_cast<unsigned long long>(wrong));
  return wrong == 0 ? 0 : 1;
} catch (const std::exception& error) {
  std::fprintf(stderr, "many_readers: %s\n", error.what());
  return 1;
}
