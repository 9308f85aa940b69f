// How small does a level get, and how fast is it encoded and decoded?
//
//   plait_bench_compression [--mesh FILE] [--refinements 4] [--level 5] [--blocks 32] [--block 256]
//                           [--runs 5] [--only TEXT]
//
// Four surfaces: a Loop surface; the same with noise of 3e-7 diagonals; with a fractal of 0.005
// diagonals; and the noisy one with normals that another rule made. Of each, some blocks of the
// finest level, positions and normals, go through pipelines of plait, through filters alone, and
// through the peers that are installed. Rates are raw bytes by the processor time of one thread.
// Floors: memcpy, and the entropy of the bytes that the filters leave: the smallest size for a
// codec that takes each byte plane of a level for random bytes of one distribution. The program
// prints a Markdown table of medians over the runs. --only: of "surface: pipeline".
#include "plait/compression.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "micro/command_line.h"
#include "micro/support.h"
#include "peers/coders.h"
#include "plait/error.h"
#include "plait/extend/edge_index.h"

namespace {

using namespace plait;
using namespace plait::bench;

// With the codec `none`, the filter alone. `plait tune` tries other pipelines.
constexpr std::array kPipelines = {"shuffle,none", "columns,none", "hierarchy,none", "normals,none",
                                   "shuffle,lz4",  "fast",         "default",        "small"};

/// The name is a pipeline or a preset. `normals` is for normals only; positions then take the other
/// filter that predicts across levels. Presets lose the stage `predicted`: it stores blocks in no
/// bytes, and encodes nothing.
Pipeline pipeline_for(const std::string& name, const AttributeSchema& schema) {
  if (name.find(',') == std::string::npos)
    return preset_pipeline(name, schema).without_predicted_stage();
  return name.starts_with("normals") && schema.name != "normal" ? "hierarchy,none" : name;
}

/// memcpy there and back.
Coder copies() {
  return {"memcpy",
          [](const RawBlock& block, std::span<std::byte> to) {
            std::memcpy(to.data(), block.raw.data(), block.raw.size());
            return block.raw.size();
          },
          [](std::span<const std::byte> encoded, const RawBlock&, std::span<std::byte> raw) {
            std::memcpy(raw.data(), encoded.data(), raw.size());
            return true;
          }};
}

/// The measured blocks of one attribute.
struct Blocks {
  const RawSurface& surface;
  std::uint32_t attribute;
  std::vector<RawBlock> all;

  /// At most this number, at the same distance.
  Blocks(const RawSurface& of, std::uint32_t number, int most) : surface(of), attribute(number) {
    const std::uint64_t count = of.finest().block_count();
    const auto wanted = std::min<std::uint64_t>(count, static_cast<std::uint64_t>(most));
    const auto side = static_cast<std::size_t>(slot_side(of.finest_level()));
    for (std::uint64_t i = 0; i < wanted; ++i) {
      const std::uint64_t block = i * count / wanted;
      const auto raw = of.bytes_of({number, of.finest_level(), block});
      const std::size_t records = raw.size() / 12;
      // Half slots have no rows of one length.
      const std::size_t columns = records % side == 0 ? side : 1;
      all.push_back({block, raw, columns, records / columns});
    }
  }
};

struct Totals {
  double raw = 0, stored = 0, encode_seconds = 0, decode_seconds = 0;
};

/// Errors: kCorruption if other bytes come back.
Totals code(const Blocks& blocks, const Coder& coder) {
  const std::size_t most = blocks.surface.finest().max_block_bytes();
  std::vector<std::byte> to(most_encoded(most)), back(most);
  Totals totals;
  for (const RawBlock& block : blocks.all) {
    const std::span<std::byte> raw = std::span(back).first(block.raw.size());
    std::size_t stored = 0;
    bool done = false;
    totals.encode_seconds += thread_seconds([&] { stored = coder.encode(block, to); });
    totals.decode_seconds += thread_seconds(
        [&] { done = stored > 0 && coder.decode(std::span(to).first(stored), block, raw); });
    if (!done || !std::ranges::equal(raw, block.raw))
      throw Error(ErrorCode::kCorruption, fmt::format("{}: other bytes came back", coder.name));
    totals.raw += static_cast<double>(block.raw.size());
    totals.stored += static_cast<double>(std::min(stored, block.raw.size()));
  }
  return totals;
}

/// The entropy in bytes of the four byte planes that the filters of a pipeline leave; 0 unless the
/// last one of several stages is `shuffle`.
double entropy(const Blocks& blocks, Pipeline pipeline) {
  if (pipeline.filters.empty() || pipeline.filters.back().name != "shuffle" ||
      pipeline.codec.name == "none")
    return 0;
  pipeline.codec = {"none"};
  const Coder filters = pipeline_coder(blocks.surface, blocks.attribute, pipeline);
  std::vector<std::byte> to(most_encoded(blocks.surface.finest().max_block_bytes()));
  std::array<std::array<double, 256>, 4> counts{};
  for (const RawBlock& block : blocks.all) {
    const std::size_t size = filters.encode(block, to);
    for (std::size_t i = 0; i < size; ++i)
      ++counts[i / (size / 4)][std::to_integer<std::size_t>(to[i])];
  }
  double bits = 0;
  for (const auto& plane : counts) {
    double all = 0;
    for (const double count : plane) all += count;
    for (const double count : plane)
      if (count > 0) bits -= count * std::log2(count / all);
  }
  return bits / 8;
}

void run(const Settings& settings) {
  const LaidOutMesh mesh =
      mesh_or_octahedron(settings.mesh, settings.refinements, LayoutKind::kAutomatic);
  Measurements table("surface|pipeline", {{"ratio"},
                                          {"bytes a position"},
                                          {"bytes a normal"},
                                          {"over entropy"},
                                          {"encode GB/s"},
                                          {"decode GB/s"}});
  for (const std::string surface : {"exact", "noise", "fractal", "noise, other normals"}) {
    Store store = make_surface(settings, mesh, surface, true);
    const RawSurface read(store);
    const Blocks attributes[] = {{read, 0, settings.blocks}, {read, 1, settings.blocks}};
    const auto measure = [&](const std::string& name, const std::array<Coder, 2>& coders,
                             double smallest) {
      for (int turn = 0; turn < settings.runs; ++turn) {
        const Totals position = code(attributes[0], coders[0]);
        const Totals normal = code(attributes[1], coders[1]);
        const auto of_both = [&](double Totals::*value) { return position.*value + normal.*value; };
        const double raw = of_both(&Totals::raw), stored = of_both(&Totals::stored);
        table.add({surface, name}, {raw / stored, 12 * position.stored / position.raw,
                                    12 * normal.stored / normal.raw,
                                    smallest > 0 ? stored / smallest : Measurements::kNone,
                                    raw / of_both(&Totals::encode_seconds) / 1e9,
                                    raw / of_both(&Totals::decode_seconds) / 1e9});
      }
    };
    const auto wanted = [&](const std::string& name) {
      const std::string full = fmt::format("{}: {}", surface, name);
      const bool is_wanted = full.find(settings.only) != std::string::npos;
      if (is_wanted) say_progress(full);
      return is_wanted;
    };
    if (wanted("memcpy")) measure("memcpy", {copies(), copies()}, 0);
    for (const std::string name : kPipelines) {
      if (!wanted(name)) continue;
      double smallest = 0;
      const auto coder_of = [&](const Blocks& blocks) {
        const Pipeline pipeline =
            pipeline_for(name, read.surroundings.attributes[blocks.attribute].schema);
        smallest += entropy(blocks, pipeline);
        return pipeline_coder(read, blocks.attribute, pipeline);
      };
      const std::array<Coder, 2> coders = {coder_of(attributes[0]), coder_of(attributes[1])};
      measure(name, coders, smallest);
    }
    for (const Coder& peer : peer_coders())
      if (wanted(peer.name)) measure(peer.name, {peer, peer}, 0);
  }
  table.print(fmt::format("blocks of {} KiB at level {}, {} runs", settings.block_kib,
                          settings.level, settings.runs));
}

}  // namespace

int main(int count, char** words) {
  return Program("plait_bench_compression", "Size and speed of pipelines and of other libraries",
                 {.refinements = 4, .block_kib = 256},
                 {"--mesh", "--refinements", "--level", "--blocks", "--block", "--runs", "--only"})
      .run(count, words, run);
}
