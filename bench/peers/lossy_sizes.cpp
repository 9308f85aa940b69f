// How small do positions get if each coordinate may change by a bound?
//
//   plait_bench_lossy_sizes [--refinements 4] [--level 5] [--directory DIR]
//
// Three surfaces: a Loop surface; with noise of 3e-7 diagonals; with a fractal of 0.005 diagonals.
// For each bound, the bytes a vertex of all levels, and the largest error measured on what a reader
// gets. Every way gets the coarsest setting whose measured error is within the bound. Draco and the
// quantised array store a mesh of one level, plait all levels with random access. Draco's
// edgebreaker changes the order of vertices, so its error is that of the same quantisation in the
// sequential encoding; its bytes include the triangles. The program prints a Markdown table.
#include <zstd.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <utility>

#include "micro/command_line.h"
#include "micro/support.h"
#include "paging/level_cursor.h"
#include "peers/compression_surfaces.h"
#include "peers/lossy_peers.h"
#include "plait/compression.h"
#include "plait/extend/copy_levels.h"
#include "plait/extend/rounding.h"
#include "plait/extend/store_access.h"
#include "plait/extend/vertex_numbering.h"
#include "plait/layout.h"
#include "plait/registry.h"

namespace {

using namespace plait;
using namespace plait::bench;

struct Settings {
  int level = 5, refinements = 4;
  std::string directory = "/tmp";
};

/// All vertices, in the order of VertexNumbering, and the triangles of the finest level.
LossyMesh mesh_of(const Settings& settings, Store& store) {
  LossyMesh mesh;
  const auto add = [&](std::span<const std::byte> bytes) {
    const std::size_t at = mesh.numbers.size();
    mesh.numbers.resize(at + bytes.size() / sizeof(float));
    std::memcpy(mesh.numbers.data() + at, bytes.data(), bytes.size());
  };
  const AttributeId id = store.attribute("position");
  add(std::as_const(store).base_bytes(id));
  for (int level = 1; level <= settings.level; ++level) {
    mesh.grids.push_back({mesh.numbers.size() / 3, static_cast<std::size_t>(slot_side(level)),
                          store.base().edge_count()});
    LevelCursor cursor(StoreAccess::open_session(store), StoreAccess::level_file(store, id, level));
    for (EdgeId edge = 0; edge < store.base().edge_count(); ++edge) add(cursor.slot(edge).bytes);
  }
  const VertexNumbering numbering(store.base().topology(), settings.level);
  for (FaceId face = 0; face < store.base().face_count(); ++face)
    for_each_triangle(settings.level, [&](const std::array<FacePoint, 3>& corners) {
      std::array<std::uint32_t, 3> triangle;
      for (std::size_t i = 0; i < 3; ++i)
        triangle[i] = static_cast<std::uint32_t>(
            numbering.number({face, settings.level, corners[i].i, corners[i].j}));
      mesh.triangles.push_back(triangle);
    });
  return mesh;
}

LossySize size_in_plait(const Settings& settings, Store& surface, const std::string& preset,
                        double bound) {
  const std::filesystem::path path = std::filesystem::path(settings.directory) / "s.plait";
  std::filesystem::remove_all(path);
  ErrorBounds bounds;
  bounds.add(fmt::format("{}", bound));
  const AttributeId id = surface.attribute("position");
  const Rounder rounder(surface.attributes()[id].schema, *bounds.of("position"),
                        std::as_const(surface).base_bytes(id));
  StoreOptions options;
  options.backend = "compressed";
  options.durability = Durability::kNone;
  options.pipeline_of = [&](const AttributeSchema& schema) {
    return pipeline_of_rounded(preset_pipeline(preset, schema), rounder.step());
  };
  Store copy =
      Store::create(path, surface.base(), options, default_backends(), surface.provenance());
  copy_levels(surface, copy, {}, bounds);
  copy.commit();
  LossySize size;
  size.bytes = std::as_const(copy).base_bytes(id).size();
  for (int level = 1; level <= settings.level; ++level)
    size.bytes += StoreAccess::level_file(copy, id, level).backend->stored_bytes();
  size.largest_error =
      largest_error(mesh_of(settings, surface).numbers, mesh_of(settings, copy).numbers);
  return size;
}

/// Indices of multiples of the step, as 32-bit integers by significance of their bytes.
LossySize size_quantised(const LossyMesh& mesh, double bound, int zstd_level) {
  const double step = 2 * bound * (1 - 1e-3);
  const std::size_t count = mesh.numbers.size();
  std::vector<unsigned char> planes(4 * count);
  LossySize size;
  for (std::size_t i = 0; i < count; ++i) {
    const double index = std::nearbyint(mesh.numbers[i] / step);
    const auto word = static_cast<std::uint32_t>(static_cast<std::int64_t>(index) + 0x40000000);
    for (std::size_t byte = 0; byte < 4; ++byte)
      planes[byte * count + i] = static_cast<unsigned char>(word >> 8 * byte);
    const double back = static_cast<float>(index * step);
    size.largest_error = std::max(size.largest_error, std::abs(back - double{mesh.numbers[i]}));
  }
  std::vector<unsigned char> to(ZSTD_compressBound(planes.size()));
  size.bytes = ZSTD_compress(to.data(), to.size(), planes.data(), planes.size(), zstd_level);
  return size;
}

int run(const Settings& settings) {
  const LaidOutMesh base = lay_out(octahedron(settings.refinements), LayoutKind::kAutomatic);
  Measurements table("surface|#bound, diagonals|way",
                     {{"bytes a vertex", 3}, {"largest error / bound", 3}});
  for (const std::string surface : {"exact", "noise", "fractal"}) {
    Store store = make_surface({.level = settings.level}, base, surface, false);
    const LossyMesh mesh = mesh_of(settings, store);
    const ErrorBound one{1, true};
    const double diagonal =
        Rounder(store.attributes()[0].schema, one, std::as_const(store).base_bytes(0))
            .result()
            .bound;
    for (const double relative : {1e-4, 1e-5, 1e-6}) {
      const double bound = relative * diagonal;
      const auto add = [&](const std::string& way, const LossySize& size) {
        const double vertices = static_cast<double>(mesh.numbers.size()) / 3;
        table.add({surface, fmt::format("{:g}", relative), way},
                  {static_cast<double>(size.bytes) / vertices, size.largest_error / bound});
      };
      for (const char* preset : {"fast", "default", "small"}) {
        say_progress(fmt::format("{} {} {}", surface, relative, preset));
        add(preset, size_in_plait(settings, store, preset, bound));
      }
      add("quantise, shuffle, zstd 3", size_quantised(mesh, bound, 3));
      add("quantise, shuffle, zstd 19", size_quantised(mesh, bound, 19));
      for (const LossyPeer& peer : lossy_peers()) {
        say_progress(fmt::format("{} {} {}", surface, relative, peer.name));
        if (const auto size = peer.size(mesh, bound)) add(peer.name, *size);
      }
    }
  }
  table.print(fmt::format("positions to level {}", settings.level));
  return 0;
}

}  // namespace

int main(int count, char** words) {
  Settings settings;
  Program program("plait_bench_lossy_sizes", "Size of rounded positions, beside other libraries");
  program.surface(settings.refinements, settings.level).directory(settings.directory);
  return program.run(count, words, [&] { return run(settings); });
}
