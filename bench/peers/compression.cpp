// How small does a level get, and how fast is it encoded and decoded?
//
//   plait_bench_compression [--mesh FILE] [--level 5] [--blocks 32] [--block 256] [--runs 5]
//                           [--surface NAME]... [--only PIPELINE]...
//
// Four surfaces: a Loop surface; the same with noise of 3e-7 diagonals; with a fractal of 0.005
// diagonals; and the noisy one with normals that another rule made. Of each, some blocks of the
// finest level, positions and normals, go through pipelines of plait, through the codecs alone, and
// through the peers that are installed. Rates are raw bytes by the processor time of one thread.
// Floors: memcpy, and the entropy of the bytes that the filters leave: the smallest size for a
// codec that takes each byte plane of a level for random bytes of one distribution. The program
// prints a Markdown table of medians over the runs.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "micro/command_line.h"
#include "micro/support.h"
#include "peers/compression_peers.h"
#include "peers/compression_surfaces.h"
#include "peers/compression_ways.h"
#include "plait/extend/block_makers.h"
#include "plait/layout.h"
#include "plait/mesh_io.h"

namespace {

using namespace plait;
using namespace plait::bench;

struct Settings {
  SurfaceSettings surface;
  int runs = 5, refinements = 4;
  std::string mesh;
  std::vector<std::string> surfaces, only;  ///< empty: all

  static bool has(const std::vector<std::string>& chosen, const std::string& name) {
    return chosen.empty() || std::ranges::find(chosen, name) != chosen.end();
  }
};

// With the codec `none`, the filter alone.
const std::array kPipelines = {"shuffle,none",
                               "columns,none",
                               "hierarchy,none",
                               "normals,none",
                               "zstd:3",
                               "lz4",
                               "shuffle,lz4",
                               "shuffle,zstd:1",
                               "shuffle,zstd:3",
                               "columns+shuffle,lz4",
                               "columns+shuffle,zstd:1",
                               "hierarchy,bitpack",
                               "hierarchy+shuffle,lz4",
                               "hierarchy+shuffle,zstd:1",
                               "hierarchy+shuffle,zstd:9",
                               "fast",
                               "default",
                               "small"};

using Way = std::function<void(const MeasuredAttribute&, Sizes&, Times&)>;

void measure(const Settings& settings, const std::string& surface, const std::string& name,
             const std::vector<MeasuredAttribute>& attributes, const Way& way,
             Measurements& table) {
  for (int run = 0; run < settings.runs; ++run) {
    Times times;
    Sizes all;
    std::vector<double> bytes_a_vertex;
    for (const MeasuredAttribute& attribute : attributes) {
      Sizes sizes;
      way(attribute, sizes, times);
      bytes_a_vertex.push_back(12 * sizes.stored / sizes.raw);
      all.raw += sizes.raw;
      all.stored += sizes.stored;
      all.entropy += sizes.entropy;
    }
    table.add({surface, name}, {all.raw / all.stored, bytes_a_vertex[0], bytes_a_vertex[1],
                                all.entropy > 0 ? all.stored / all.entropy : Measurements::kNone,
                                all.raw / times.encode / 1e9, all.raw / times.decode / 1e9});
  }
}

int run(const Settings& settings) {
  const LaidOutMesh mesh = lay_out(
      settings.mesh.empty() ? octahedron(settings.refinements) : read_base_mesh(settings.mesh),
      LayoutKind::kAutomatic);
  Measurements table("surface|pipeline", {{"ratio"},
                                          {"bytes a position"},
                                          {"bytes a normal"},
                                          {"over entropy"},
                                          {"encode GB/s"},
                                          {"decode GB/s"}});
  for (const std::string surface : {"exact", "noise", "fractal", "noise, other normals"}) {
    if (!Settings::has(settings.surfaces, surface)) continue;
    Store store = make_surface(settings.surface, mesh, surface);
    MeasuredSurface read(store);
    std::vector<MeasuredAttribute> attributes;
    for (const char* name : {"position", "normal"})
      attributes.push_back(read_attribute(settings.surface, store, name, read));
    const auto add = [&](const std::string& name, const Way& way) {
      if (name != "memcpy" && !Settings::has(settings.only, name)) return;
      say_progress(fmt::format("{}: {}", surface, name));
      measure(settings, surface, name, attributes, way, table);
    };
    add("memcpy", [&](const MeasuredAttribute& of, Sizes& sizes, Times& times) {
      run_copies(of, sizes, times);
    });
    for (const std::string pipeline : kPipelines)
      add(pipeline, [&](const MeasuredAttribute& of, Sizes& sizes, Times& times) {
        run_pipeline(of, pipeline, sizes, times);
      });
    if (surface == "exact" && settings.surface.level <= kMostMadeLevels)
      add("predicted,none", [&](const MeasuredAttribute& of, Sizes& sizes, Times& times) {
        run_predicted(of, sizes, times);
      });
    for (const CompressionPeer& peer : compression_peers())
      add(peer.name, [&](const MeasuredAttribute& of, Sizes& sizes, Times& times) {
        run_peer(of, peer, sizes, times);
      });
  }
  table.print(fmt::format("blocks of {} KiB at level {}, {} runs", settings.surface.block_kib,
                          settings.surface.level, settings.runs));
  return 0;
}

}  // namespace

int main(int count, char** words) {
  Settings settings;
  Program program("plait_bench_compression", "Size and speed of pipelines and of other libraries");
  program.mesh(settings.mesh, "an octahedron that is refined first")
      .surface(settings.refinements, settings.surface.level)
      .number("--blocks", settings.surface.blocks, 1, 1000000,
              "Blocks of each attribute, at the same distance")
      .number("--block", settings.surface.block_kib, 4, 65536, "KiB of a block")
      .runs(settings.runs);
  CommandLine& options = program.options();
  options.add_option("--surface", settings.surfaces, "Only this surface; may be repeated")
      ->allow_extra_args(false);
  options.add_option("--only", settings.only, "Only this way; may be repeated")
      ->allow_extra_args(false);
  return program.run(count, words, [&] { return run(settings); });
}
