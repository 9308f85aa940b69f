// The program whose memory memory_test.cpp measures. It builds a base mesh, refines it into a
// scratch store and prints one line of figures. Each measurement needs its own process, because the
// peak of a process never falls.
//
//   plait_memory_probe MESH|icosahedron LEVELS BUDGET BACKEND EXECUTOR THREADS NORMALS(0|1) SCRATCH
//
// Output: peak bytes with the base mesh alone, peak bytes at the end, bytes of the base mesh and of
// other memory that is not part of the budget, raw bytes of the level files, base level, vertices,
// seconds of refinement and commit. The peak is VmHWM, because ru_maxrss includes the peak of the
// parent process.
#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <fstream>
#include <string>
#include <utility>

#include "plait/extend/store_access.h"
#include "plait/layout.h"
#include "plait/mesh_io.h"
#include "plait/registry.h"
#include "plait/store.h"
#include "plait/subdivide.h"
#include "support/test_meshes.h"

namespace {

using namespace plait;

std::uint64_t peak_rss_bytes() {
  std::ifstream status("/proc/self/status");
  std::uint64_t kibibytes = 0;
  for (std::string word; status >> word;)
    if (word == "VmHWM:") {
      status >> kibibytes;
      break;
    }
  return kibibytes * 1024;
}

/// The base mesh in the automatic layout.
BaseMesh base_mesh(const std::string& source, int base_level) {
  BaseMesh mesh =
      source == "icosahedron" ? BaseMesh::build(test::icosahedron()) : read_base_mesh(source);
  if (base_level > 0) mesh = rebase(mesh, base_level, Scheme::kLoop);
  return lay_out(mesh, LayoutKind::kAutomatic).mesh;
}

void run(char** arguments) {
  const std::string source = arguments[1];
  SubdivideOptions what;
  what.levels = std::stoi(arguments[2]);
  what.executor = executor_from_name(arguments[5]);
  what.threads = std::stoi(arguments[6]);
  what.normals = std::stoi(arguments[7]) != 0;
  StoreOptions options;
  options.budget_bytes = std::stoull(arguments[3]);
  options.backend = arguments[4];
  options.block_bytes = 64 << 10;
  options.durability = Durability::kNone;
  constexpr std::uint64_t kMaxSlotBytes = 16 << 10;
  const int base_level = rebase_levels(what.levels, sizeof(Vector3<float>), kMaxSlotBytes);

  Store store = Store::create(arguments[8], base_mesh(source, base_level), options,
                              default_backends(), {.base_level = base_level});
  add_base_positions(store);
  const std::uint64_t peak_before = peak_rss_bytes();
  const auto start = std::chrono::steady_clock::now();
  PlannedSubdivision levels = plan_subdivision(store, what);
  levels.run();
  store.commit();
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;

  std::uint64_t level_bytes = 0;
  std::uint64_t base_bytes = store.base().memory_bytes() + levels.needs().resident;
  for (AttributeId id = 0; id < store.attributes().size(); ++id) {
    base_bytes += std::as_const(store).base_bytes(id).size();
    for (int level = base_level + 1; level <= what.levels; ++level)
      level_bytes += StoreAccess::level_file(store, id, level).geometry.total_bytes();
  }
  const std::uint64_t vertices = counts_at_level(store.base(), what.levels - base_level).vertices;
  fmt::print("{} {} {} {} {} {} {:.2f}\n", peak_before, peak_rss_bytes(), base_bytes, level_bytes,
             base_level, vertices, seconds.count());
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 9) return 2;
  try {
    run(arguments);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
  return 0;
}
