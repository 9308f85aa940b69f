// How small does a level get, and how fast is it encoded and decoded?
//
//   plait_bench_compression [--mesh FILE] [--level 5] [--blocks 32] [--runs 5] [--json FILE]
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
#include <cmath>
#include <cstring>
#include <functional>
#include <string>
#include <tuple>
#include <vector>

#include "command_line.h"
#include "compression_peers.h"
#include "plait/backends/pipeline.h"
#include "plait/backends/registry.h"
#include "plait/edge_index.h"
#include "plait/kernels/block_makers.h"
#include "plait/kernels/displace.h"
#include "plait/kernels/visit_vertices.h"
#include "plait/layout.h"
#include "plait/level_cursor.h"
#include "plait/mesh_io.h"
#include "support.h"

namespace {

using namespace plait;
using namespace plait::bench;
using Bytes = std::vector<std::byte>;
using Point = Vector3<float>;

struct Settings {
  int level = 5, blocks = 32, runs = 5, refinements = 4;
  std::uint64_t block_bytes = 1 << 18;
  std::string mesh, json;
};

// With the codec `none`, a filter and a copy.
const std::array kPipelines = {"shuffle,none",
                               "bytedelta,none",
                               "lorenzo,none",
                               "parallelogram,none",
                               "hierarchy,none",
                               "zstd:3",
                               "lz4",
                               "shuffle,lz4",
                               "shuffle,zstd:1",
                               "shuffle,zstd:3",
                               "shuffle+bytedelta,zstd:1",
                               "lorenzo+shuffle,lz4",
                               "lorenzo+shuffle,zstd:1",
                               "parallelogram+shuffle,lz4",
                               "parallelogram+shuffle,zstd:1",
                               "parallelogram+shuffle,zstd:9",
                               "hierarchy+shuffle,lz4",
                               "hierarchy+shuffle,zstd:1",
                               "hierarchy+shuffle,zstd:9"};

/// Normals as many programs make them: the sum of the cross products of the triangles around.
void make_other_normals(Store& store) {
  visit_vertices(store, {.name = "other normals"},
                 std::tuple{rings_of<Point>("position"), overwrites<Point>("normal")},
                 [](const VertexRun& run, const VertexRings<Point>& ring, std::span<Point> normal) {
                   const int n = ring.valence(), triangles = ring.is_border() ? n - 1 : n;
                   for (std::size_t i = 0; i < run.count; ++i) {
                     Point sum{};
                     for (int k = 0; k < triangles; ++k)
                       sum = sum + cross(ring.neighbour(i, k) - ring.vertex(i),
                                         ring.neighbour(i, (k + 1) % n) - ring.vertex(i));
                     normal[i] = normalized(sum);
                   }
                 });
}

Store make_surface(const Settings& settings, const LaidOutMesh& mesh, const std::string& name) {
  StoreOptions options;
  options.backend = "memory";
  options.block_bytes = settings.block_bytes;
  options.budget_bytes = 256 << 20;
  Store store = Store::create({}, mesh, options, default_backends());
  add_base_positions(store);
  subdivide(store, {.executor = ExecutorKind::kFused, .levels = settings.level, .normals = true});
  if (name.starts_with("noise"))
    displace(store, {.kind = DisplacementKind::kNoise, .amplitude = 3e-7});
  if (name == "fractal") displace(store, {.kind = DisplacementKind::kFractal, .amplitude = 0.005});
  if (name == "noise, other normals") make_other_normals(store);
  return store;
}

/// One attribute: the raw bytes of its levels, and what filters must know of them.
struct Attribute {
  AttributeSchema schema;
  std::vector<Bytes> levels;  ///< [level - 1]
  LevelSurroundings surroundings;
  const LevelGeometry* finest;
  std::vector<std::uint64_t> blocks;

  std::span<const std::byte> bytes_of(int level, std::uint64_t block) const {
    const LevelGeometry& geometry =
        *surroundings.attributes[0].levels[static_cast<std::size_t>(level - 1)];
    return std::span(levels[static_cast<std::size_t>(level - 1)])
        .subspan(geometry.block_offset(block), geometry.block_bytes(block));
  }
};

Attribute read_attribute(const Settings& settings, Store& store, const std::string& name) {
  const AttributeId id = store.attribute(name);
  Attribute attribute{store.attributes()[id].schema, {}, {}, nullptr, {}};
  AttributeLevels levels{0, attribute.schema, std::as_const(store).base_bytes(id), {}};
  for (int level = 1; level <= settings.level; ++level) {
    LevelFile& file = store.level_file(id, level);
    LevelCursor cursor(store.open_session(), file);
    Bytes& bytes = attribute.levels.emplace_back();
    for (EdgeId edge = 0; edge < store.base().edge_count(); ++edge) {
      const auto slot = cursor.slot(edge).bytes;
      bytes.insert(bytes.end(), slot.begin(), slot.end());
    }
    levels.levels.push_back(&file.geometry);
    attribute.finest = &file.geometry;
  }
  attribute.surroundings = {store.base().topology(), 0, {levels}, store.base().positions()};
  // The same distance between the measured blocks.
  const std::uint64_t count = attribute.finest->block_count();
  const auto wanted = std::min<std::uint64_t>(count, static_cast<std::uint64_t>(settings.blocks));
  for (std::uint64_t i = 0; i < wanted; ++i) attribute.blocks.push_back(i * count / wanted);
  return attribute;
}

struct Sizes {
  double raw = 0, stored = 0, entropy = 0;  ///< bytes
};
struct Times {
  double encode = 0, decode = 0;  ///< seconds
};

/// The entropy of bytes with these counts, in bytes.
double entropy(const std::array<std::uint64_t, 256>& counts) {
  double all = 0, bits = 0;
  for (const std::uint64_t count : counts) all += static_cast<double>(count);
  for (const std::uint64_t count : counts)
    if (count > 0) bits -= static_cast<double>(count) * std::log2(static_cast<double>(count) / all);
  return bits / 8;
}

/// A pipeline for the blocks of one attribute.
class Coder {
 public:
  Coder(const Attribute& attribute, const std::string& pipeline, int level)
      : attribute_(attribute) {
    FilterLevel filter_level;
    filter_level.schema = attribute.schema;
    filter_level.geometry = attribute.finest;
    filter_level.level = level;
    filter_level.surroundings = &attribute.surroundings;
    pipeline_ = default_pipelines().make(pipeline, filter_level);
    const std::size_t most = attribute.finest->max_block_bytes();
    buffers_.assign(pipeline_.filters.size() + 1, Bytes(most));
    encoded_.resize(pipeline_.codec->bound(most));
    std::size_t scratch = 0;
    for (const auto& filter : pipeline_.filters)
      scratch = std::max(scratch, filter->scratch_bytes());
    scratch_.resize(scratch);
  }

  /// Encodes and decodes a block. Errors: kCorruption if other bytes come back.
  void run(std::uint64_t block, std::span<const std::byte> raw, Sizes& sizes, Times& times,
           std::vector<std::array<std::uint64_t, 256>>* counts) {
    std::vector<std::span<const std::byte>> context;
    std::array<ContextBlock, kMostContextBlocks> blocks;
    if (!pipeline_.filters.empty())
      for (std::size_t i = 0, n = pipeline_.filters[0]->context(block, blocks); i < n; ++i)
        context.push_back(attribute_.bytes_of(blocks[i].level, blocks[i].block));
    const FilterBlock with{block, context, scratch_};
    std::size_t stored = 0;
    times.encode += thread_seconds([&] {
      std::span<const std::byte> from = raw;
      for (std::size_t i = 0; i < pipeline_.filters.size(); ++i) {
        const std::span<std::byte> to(buffers_[i].data(), raw.size());
        pipeline_.filters[i]->encode(with, from, to);
        from = to;
      }
      stored = pipeline_.codec->compress(from, encoded_).value_or(raw.size());
    });
    if (counts != nullptr) {
      const Bytes& filtered = buffers_[pipeline_.filters.size() - 1];
      for (std::size_t i = 0; i < raw.size(); ++i)
        ++(*counts)[i / (raw.size() / counts->size())][std::to_integer<std::size_t>(filtered[i])];
    }
    times.decode += thread_seconds([&] {
      std::span<std::byte> to(buffers_.back().data(), raw.size());
      pipeline_.codec->decompress(std::span(encoded_).first(stored), to);
      for (std::size_t i = pipeline_.filters.size(); i > 0; --i) {
        const std::span<const std::byte> from = to;
        to = {buffers_[i - 1].data(), raw.size()};
        pipeline_.filters[i - 1]->decode(with, from, to);
      }
    });
    if (!std::ranges::equal(std::span(buffers_.front()).first(raw.size()), raw))
      throw Error(ErrorCode::kCorruption, "decode: other bytes came back");
    sizes.raw += static_cast<double>(raw.size());
    sizes.stored += static_cast<double>(std::min(stored, raw.size()));
  }

  bool ends_with_shuffle(const std::string& pipeline) const {
    return !pipeline_.filters.empty() && pipeline.find("shuffle,") != std::string::npos &&
           !pipeline.ends_with(",none");
  }

 private:
  const Attribute& attribute_;
  Pipeline pipeline_;
  std::vector<Bytes> buffers_;
  Bytes encoded_, scratch_;
};

void run_pipeline(const Settings& settings, const Attribute& attribute, const std::string& pipeline,
                  Sizes& sizes, Times& times) {
  Coder coder(attribute, pipeline, settings.level);
  std::vector<std::array<std::uint64_t, 256>> counts(4);
  const bool planes = coder.ends_with_shuffle(pipeline);
  for (const std::uint64_t block : attribute.blocks)
    coder.run(block, attribute.bytes_of(settings.level, block), sizes, times,
              planes ? &counts : nullptr);
  if (planes)
    for (const auto& plane : counts) sizes.entropy += entropy(plane);
}

/// Blocks that the scheme makes again: encoding compares a block with what is made, decoding makes
/// it. An entry of the block table is all that is stored.
void run_predicted(const Settings& settings, const Attribute& attribute, Sizes& sizes,
                   Times& times) {
  FilterLevel level;
  level.schema = attribute.schema;
  level.geometry = attribute.finest;
  level.level = settings.level;
  level.surroundings = &attribute.surroundings;
  const std::string text =
      fmt::format("predicted:loop/{}/float32/{},none", attribute.schema.name, settings.level);
  const Pipeline pipeline = default_pipelines().make(text, level);
  Bytes back(attribute.finest->max_block_bytes());
  for (const std::uint64_t block : attribute.blocks) {
    const auto raw = attribute.bytes_of(settings.level, block);
    const std::span<std::byte> made = std::span(back).first(raw.size());
    bool is_made = false;
    times.encode += thread_seconds([&] { is_made = pipeline.maker->makes(block, raw); });
    times.decode += thread_seconds([&] { pipeline.maker->make(block, made); });
    if (!is_made || !std::ranges::equal(made, raw))
      throw Error(ErrorCode::kCorruption, "predict: other bytes came back");
    sizes.raw += static_cast<double>(raw.size());
    sizes.stored += sizeof(BlockEntry);
  }
}

void run_peer(const Settings& settings, const Attribute& attribute, const CompressionPeer& peer,
              Sizes& sizes, Times& times) {
  for (const std::uint64_t block : attribute.blocks) {
    const auto raw = attribute.bytes_of(settings.level, block);
    const auto side = static_cast<std::size_t>(slot_side(settings.level));
    const std::size_t records = raw.size() / 12;
    // Half slots have no rows of one length.
    const PeerBlock shape{raw, records % side == 0 ? side : 1,
                          records % side == 0 ? records / side : records};
    Bytes encoded, back(raw.size());
    times.encode += thread_seconds([&] { encoded = peer.encode(shape); });
    bool done = false;
    times.decode += thread_seconds([&] { done = peer.decode(encoded, shape, back); });
    if (!done || encoded.empty() || !std::ranges::equal(back, raw))
      throw Error(ErrorCode::kCorruption, fmt::format("{}: other bytes came back", peer.name));
    sizes.raw += static_cast<double>(raw.size());
    sizes.stored += static_cast<double>(std::min(encoded.size(), raw.size()));
  }
}

void run_copies(const Settings& settings, const Attribute& attribute, Sizes& sizes, Times& times) {
  Bytes to(attribute.finest->max_block_bytes()), back(to.size());
  for (const std::uint64_t block : attribute.blocks) {
    const auto raw = attribute.bytes_of(settings.level, block);
    times.encode += thread_seconds([&] { std::memcpy(to.data(), raw.data(), raw.size()); });
    times.decode += thread_seconds([&] { std::memcpy(back.data(), to.data(), raw.size()); });
    sizes.raw += static_cast<double>(raw.size());
    sizes.stored += static_cast<double>(raw.size());
  }
}

using Way = std::function<void(const Attribute&, Sizes&, Times&)>;

void measure(const Settings& settings, const std::string& surface, const std::string& name,
             const std::vector<Attribute>& attributes, const Way& way,
             nlohmann::ordered_json& figures) {
  std::vector<double> encode, decode;
  std::vector<double> bytes_a_vertex;
  Sizes all;
  for (int run = 0; run < settings.runs; ++run) {
    Times times;
    all = {};
    bytes_a_vertex.clear();
    for (const Attribute& attribute : attributes) {
      Sizes sizes;
      way(attribute, sizes, times);
      bytes_a_vertex.push_back(12 * sizes.stored / sizes.raw);
      all.raw += sizes.raw;
      all.stored += sizes.stored;
      all.entropy += sizes.entropy;
    }
    encode.push_back(all.raw / times.encode / 1e9);
    decode.push_back(all.raw / times.decode / 1e9);
  }
  const std::string floor =
      all.entropy > 0 ? fmt::format("{:.2f}", all.stored / all.entropy) : std::string("-");
  fmt::print("| {} | {} | {:.2f} | {:.2f} + {:.2f} | {} | {:.2f} | {:.2f} |\n", surface, name,
             all.raw / all.stored, bytes_a_vertex[0], bytes_a_vertex[1], floor, median(encode),
             median(decode));
  std::fflush(stdout);
  figures.push_back({{"surface", surface},
                     {"way", name},
                     {"ratio", all.raw / all.stored},
                     {"position_bytes_a_vertex", bytes_a_vertex[0]},
                     {"normal_bytes_a_vertex", bytes_a_vertex[1]},
                     {"over_entropy", all.entropy > 0 ? all.stored / all.entropy : 0},
                     {"encode_gb_a_second", median(encode)},
                     {"decode_gb_a_second", median(decode)}});
}

int run(const Settings& settings) {
  const LaidOutMesh mesh = lay_out(
      settings.mesh.empty() ? octahedron(settings.refinements) : read_base_mesh(settings.mesh),
      LayoutKind::kAutomatic);
  nlohmann::ordered_json figures = nlohmann::json::array();
  fmt::print(
      "| surface | pipeline | ratio | bytes a vertex | over entropy | encode GB/s | decode "
      "GB/s |\n|---|---|---|---|---|---|---|\n");
  for (const std::string surface : {"exact", "noise", "fractal", "noise, other normals"}) {
    say_progress(surface);
    Store store = make_surface(settings, mesh, surface);
    std::vector<Attribute> attributes;
    for (const char* name : {"position", "normal"})
      attributes.push_back(read_attribute(settings, store, name));
    const auto add = [&](const std::string& name, const Way& way) {
      measure(settings, surface, name, attributes, way, figures);
    };
    add("memcpy", [&](const Attribute& of, Sizes& sizes, Times& times) {
      run_copies(settings, of, sizes, times);
    });
    for (const std::string pipeline : kPipelines)
      add(pipeline, [&](const Attribute& of, Sizes& sizes, Times& times) {
        run_pipeline(settings, of, pipeline, sizes, times);
      });
    if (surface == "exact" && settings.level <= kMostMadeLevels)
      add("predicted,none", [&](const Attribute& of, Sizes& sizes, Times& times) {
        run_predicted(settings, of, sizes, times);
      });
    for (const CompressionPeer& peer : compression_peers())
      add(peer.name, [&](const Attribute& of, Sizes& sizes, Times& times) {
        run_peer(settings, of, peer, sizes, times);
      });
  }
  write_json(settings.json, figures);
  return 0;
}

}  // namespace

int main(int count, char** words) {
  Settings settings;
  return run_program(
      "plait_bench_compression", "Size and speed of pipelines and of other libraries", count, words,
      [&](CommandLine& app) {
        add_mesh_option(app, settings.mesh, "an octahedron that is refined first");
        add_number_option(app, "--refinements", settings.refinements, 0, 8,
                          "How often the octahedron is refined");
        add_number_option(app, "--level", settings.level, 1, 10,
                          "The level whose blocks are coded");
        add_number_option(app, "--blocks", settings.blocks, 1, 1000000,
                          "Blocks of each attribute, at the same distance");
        add_runs_option(app, settings.runs);
        add_json_option(app, settings.json);
      },
      [&] { return run(settings); });
}
