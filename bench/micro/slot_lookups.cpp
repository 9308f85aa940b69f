// How long does it take to find the slot of an edge (LevelGeometry::slot), if faces have depths of
// their own, compared with a level of all faces?
//
//   plait_bench_slot_lookups [--level 5] [--refinements 6] [--reads 1000000] [--runs 5]
//
// Each look-up takes a random edge, and the next edge depends on what it found, so look-ups follow
// one another. The floor draws the edges alone. `all faces`: the level of a mesh without depths,
// whose slots are all whole; `with a border`: the same mesh without one face; `depths`: a quarter
// of the faces does not have the level, in runs of 1 to 1024 faces, as on a surface, or one by one.
// The program prints a Markdown table of medians over the runs.
#include <fmt/format.h>

#include <cstdint>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "micro/command_line.h"
#include "micro/support.h"
#include "plait/base_mesh.h"
#include "plait/extend/base_relative_level.h"
#include "plait/extend/level_geometry.h"

namespace {

using namespace plait;
using namespace plait::bench;

/// Each face has the level, or ends at the one before it.
std::vector<std::uint8_t> depths_of(std::uint64_t faces, int level, std::uint64_t longest_run,
                                    std::mt19937_64& random) {
  std::vector<std::uint8_t> depths;
  while (depths.size() < faces)
    depths.insert(depths.end(), 1 + random() % longest_run,
                  static_cast<std::uint8_t>(level - static_cast<int>(random() % 4 == 0)));
  depths.resize(faces);
  return depths;
}

/// Nanoseconds of one look-up. `look(edge)` gives a number.
template <class Look>
double lookup_ns(std::uint64_t edges, int reads, Look look) {
  std::uint64_t state = 1, sum = 0;
  const double taken = seconds([&] {
    for (int read = 0; read < reads; ++read) {
      state = state * 6364136223846793005u + 1442695040888963407u;
      const auto edge = static_cast<EdgeId>((state >> 32) * edges >> 32);
      sum += look(edge);
      state += sum & 1;
    }
  });
  asm volatile("" ::"r"(sum));  // the compiler may not leave the look-ups out
  return 1e9 * taken / reads;
}

void run(const Settings& settings) {
  const BaseMesh base = mesh_or_octahedron({}, settings.refinements, LayoutKind::kAutomatic).mesh;
  IndexedMesh open;
  open.positions.assign(base.positions().begin(), base.positions().end());
  open.faces.assign(base.faces().begin() + 1, base.faces().end());
  std::mt19937_64 random(42);
  const std::vector<std::pair<std::string, BaseMesh>> meshes = {
      {"all faces", base},
      {"with a border", BaseMesh::build(std::move(open))},
      {"depths in runs",
       base.with_depths(depths_of(base.face_count(), settings.level, 1024, random))},
      {"depths of single faces",
       base.with_depths(depths_of(base.face_count(), settings.level, 1, random))}};
  Measurements table("slots", {{"ns", 1}, {"less the edges alone, ns", 1}});
  for (int turn = 0; turn < settings.runs; ++turn)
    for (const auto& [name, mesh] : meshes) {
      const LevelGeometry geometry =
          mesh.geometry(BaseRelativeLevel(settings.level), sizeof(Vector3<float>), 1 << 16);
      const double floor =
          lookup_ns(mesh.edge_count(), settings.reads, [](EdgeId edge) { return edge; });
      const double found = lookup_ns(mesh.edge_count(), settings.reads, [&](EdgeId edge) {
        const Slot slot = geometry.slot(edge);
        return slot.offset + slot.bytes + static_cast<std::uint64_t>(slot.shape);
      });
      table.add({name}, {found, found - floor});
    }
  table.print(fmt::format("{} edges, level {}, {} look-ups, {} runs", base.edge_count(),
                          settings.level, settings.reads, settings.runs));
}

}  // namespace

int main(int count, char** words) {
  return Program("plait_bench_slot_lookups", "Slots of random edges",
                 {.refinements = 6, .reads = 1000000},
                 {"--refinements", "--level", "--reads", "--runs"})
      .run(count, words, run);
}
