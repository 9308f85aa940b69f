// What does at(level, i, j) of a store cost, compared with plain arrays, when everything is in
// memory?
//
//   plait_bench_at_overhead [--mesh FILE] [--level 5] [--runs 5] [--directory .]
//
// The same source, plait/extend/rule_patches.h, refines the same mesh in three kinds of storage:
// the library's in-core mesh of plain arrays, a store in memory, and a store on disk whose blocks
// are all in frames. All memory is allocated and touched before the measurement. Every counted run
// begins with the base positions and computes all levels. A turn runs the three once each, and
// ratios are computed within a turn, so that a change of the machine's speed does not affect them.
// The program fails unless all vertices agree. Without --mesh it takes an octahedron, refined in
// memory to 2048 faces.
#include <fmt/format.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "micro/command_line.h"
#include "micro/support.h"
#include "plait/error.h"
#include "plait/extend/in_core_mesh.h"
#include "plait/extend/patch.h"
#include "plait/extend/rule_patches.h"
#include "plait/registry.h"
#include "plait/store.h"
#include "plait/store_info.h"
#include "plait/subdivide.h"

namespace {

using namespace plait;
using namespace plait::bench;
using Position = Vector3<float>;

/// The code that is measured.
template <PatchMesh Mesh>
void refine_from_base(Mesh& mesh, const BaseMesh& base, int levels) {
  for (std::size_t vertex = 0; vertex < base.vertex_count(); ++vertex)
    mesh.base_records()[vertex] = narrow<float>(base.positions()[vertex]);
  for (int level = 1; level <= levels; ++level)
    refine_patches(mesh, level, loop_scheme().rule<float>());
}

template <PatchMesh First, PatchMesh Second>
std::uint64_t count_differences(First& first, Second& second, int level) {
  first.activate(level, 1, 0);
  second.activate(level, 1, 0);
  std::uint64_t differences = 0;
  const std::int64_t size = std::int64_t{1} << level;
  for (FaceId face = 0; face < first.topology().faces.size(); ++face) {
    const auto here = first.patch(face);
    const auto there = second.patch(face);
    for (std::int64_t j = 0; j <= size; ++j)
      for (std::int64_t i = 0; i + j <= size; ++i)
        differences += !(here.at(level, i, j) == there.at(level, i, j));
  }
  return differences;
}

/// A store that has all levels, and a budget large enough for all of them.
Store resident_store(const BaseMesh& base, const Settings& settings, const std::string& backend,
                     const std::filesystem::path& path) {
  StoreOptions options;
  options.backend = backend;
  options.budget_bytes =
      2 * sizeof(Position) * counts_at_level(base, settings.level).vertices + (64 << 20);
  options.durability = Durability::kNone;
  Store store = Store::create(path, base, options, default_backends());
  add_base_positions(store);
  for (int level = 1; level <= settings.level; ++level)
    store.add_level(store.attribute("position"));
  return store;
}

struct Subject {
  std::string name;
  std::function<void()> work;
};

void run(const Settings& settings) {
  const BaseMesh base = mesh_or_octahedron(settings.mesh, 4, LayoutKind::kAutomatic).mesh;
  InCoreMesh<Position> in_core(base, settings.level);
  Store in_memory = resident_store(base, settings, "memory", {});
  Store on_disk = resident_store(base, settings, "pread", settings.store());
  const auto patches_of = [](Store& store) {
    return StorePatches<Position>(store, store.attribute("position"), store.options().budget_bytes);
  };
  auto memory_patches = patches_of(in_memory), disk_patches = patches_of(on_disk);
  const auto refine = [&](auto& mesh) {
    return [&] { refine_from_base(mesh, base, settings.level); };
  };
  const Subject subjects[] = {{"InCoreMesh", refine(in_core)},
                              {"store, memory", refine(memory_patches)},
                              {"store, warm pread window", refine(disk_patches)}};
  const std::uint64_t vertices = counts_at_level(base, settings.level).vertices;
  Measurements table("at() over",
                     {{"seconds", 3, true}, {"ns a vertex", 1}, {"over InCoreMesh", 2, true}});
  for (int turn = 0; turn <= settings.runs; ++turn)
    for (double first = 0; const Subject& subject : subjects) {
      say_progress(fmt::format("turn {} of {}: {}", turn, settings.runs, subject.name));
      const double time = seconds(subject.work);
      if (first == 0) first = time;
      if (turn > 0)  // the first turn only touches the memory
        table.add({subject.name}, {time, 1e9 * time / static_cast<double>(vertices), time / first});
    }
  const std::uint64_t read = on_disk.info().paging.blocks_read;
  const std::uint64_t differences = count_differences(in_core, memory_patches, settings.level) +
                                    count_differences(in_core, disk_patches, settings.level);
  if (differences > 0)
    throw Error(ErrorCode::kCorruption, fmt::format("{} vertices differ", differences));
  if (read > 0)
    throw Error(ErrorCode::kBadState,
                fmt::format("{} blocks were read: not all blocks are resident", read));
  table.print(fmt::format("{} vertices at level {}, {} runs, one thread", vertices, settings.level,
                          settings.runs));
}

}  // namespace

int main(int count, char** words) {
  return Program("plait_bench_at_overhead",
                 "The cost of at(level, i, j) of a store, compared with plain arrays", {},
                 {"--mesh", "--level", "--runs", "--directory"})
      .run(count, words, run);
}
