#include "engine/store/format_reader.h"

#include <fmt/format.h>
#include <lz4.h>
#include <xxhash.h>
#include <zstd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace format {
namespace {

void require(bool right, const std::string& what) {
  if (!right) throw std::runtime_error(what);
}

Bytes read_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  require(file.good(), path.string());
  return {std::istreambuf_iterator<char>(file), {}};
}

std::uint64_t number(const Bytes& bytes, std::size_t offset, int size) {
  std::uint64_t value = 0;
  for (int i = size - 1; i >= 0; --i)
    value = value << 8 | bytes.at(offset + static_cast<std::size_t>(i));
  return value;
}
std::uint32_t u16(const Bytes& bytes, std::size_t offset) {
  return bytes.at(offset) | static_cast<std::uint32_t>(bytes.at(offset + 1)) << 8;
}
std::uint32_t u32(const Bytes& bytes, std::size_t offset) {
  return static_cast<std::uint32_t>(number(bytes, offset, 4));
}
std::uint64_t u64(const Bytes& bytes, std::size_t offset) { return number(bytes, offset, 8); }

bool starts_with(const Bytes& bytes, const std::string& magic) {
  return bytes.size() >= magic.size() && std::memcmp(bytes.data(), magic.data(), magic.size()) == 0;
}

std::size_t component_bytes(unsigned type) {
  static constexpr std::size_t kBytes[] = {0, 4, 8, 1, 2, 4, 8, 1, 2, 4, 8};
  require(type >= 1 && type <= 10, "component type");
  return kBytes[type];
}

void append(Bytes& bytes, std::uint64_t value, int size) {
  for (int i = 0; i < size; ++i) bytes.push_back(static_cast<unsigned char>(value >> (8 * i)));
}

std::uint64_t block_checksum(const Store& store, std::uint32_t attribute, std::uint32_t level,
                             std::uint64_t block, const Bytes& stored) {
  Bytes identity(store.uuid.begin(), store.uuid.end());
  append(identity, attribute, 4);
  append(identity, level, 4);
  const std::uint64_t level_seed = XXH3_64bits(identity.data(), identity.size());
  Bytes block_number;
  append(block_number, block, 8);
  const std::uint64_t seed =
      XXH3_64bits_withSeed(block_number.data(), block_number.size(), level_seed);
  return XXH3_64bits_withSeed(stored.data(), stored.size(), seed);
}

/// A pipeline taken apart: stages in the order of encoding.
struct Stages {
  bool shuffle = false;
  std::string codec = "none";
};

Stages stages_of(std::string pipeline) {
  Stages stages;
  if (const std::size_t comma = pipeline.find(','); comma != std::string::npos) {
    const std::string filters = pipeline.substr(0, comma);
    require(filters == "shuffle" || filters == "none", "filter");
    stages.shuffle = filters == "shuffle";
    pipeline.erase(0, comma + 1);
  }
  stages.codec = pipeline.substr(0, pipeline.find(':'));
  return stages;
}

Bytes decoded(const std::string& pipeline, const Bytes& stored, std::size_t raw_bytes,
              std::size_t width) {
  const Stages stages = stages_of(pipeline);
  Bytes filtered(raw_bytes);
  if (stages.codec == "lz4") {
    const int got = LZ4_decompress_safe(
        reinterpret_cast<const char*>(stored.data()), reinterpret_cast<char*>(filtered.data()),
        static_cast<int>(stored.size()), static_cast<int>(raw_bytes));
    require(got == static_cast<int>(raw_bytes), "lz4 block");
  } else {
    require(stages.codec == "zstd", "codec");
    require(ZSTD_decompress(filtered.data(), raw_bytes, stored.data(), stored.size()) == raw_bytes,
            "zstd frame");
  }
  if (!stages.shuffle) return filtered;
  Bytes raw = filtered;
  const std::size_t components = raw_bytes / width;
  for (std::size_t i = 0; i < components; ++i)
    for (std::size_t plane = 0; plane < width; ++plane)
      raw[i * width + plane] = filtered[plane * components + i];
  return raw;
}

constexpr std::uint32_t kInShards = 2, kWithLog = 8, kSharedFiles = 16;  ///< of the required flags

Bytes read_manifest_slot(const std::filesystem::path& path) {
  const Bytes manifest = read_file(path);
  require(manifest.size() == 8192, "manifest size");
  Bytes newest;
  for (const std::ptrdiff_t slot_number : {0, 1}) {
    const auto first = manifest.begin() + slot_number * 4096;
    const Bytes slot(first, first + 4096);
    if (!starts_with(slot, "\x89plait\r\n") || u64(slot, 4088) != XXH3_64bits(slot.data(), 4088))
      continue;
    require(u64(slot, 40) % 2 == static_cast<std::uint64_t>(slot_number), "slot of the sequence");
    if (newest.empty() || u64(slot, 40) > u64(newest, 40)) newest = slot;
  }
  require(!newest.empty(), "no slot");
  require(u32(newest, 8) == 3 &&
              (u32(newest, 12) == 0 || u32(newest, 12) == kInShards ||
               u32(newest, 12) == kWithLog || u32(newest, 12) == (kInShards | kSharedFiles)) &&
              u32(newest, 16) <= 7,
          "version, flags");
  require(u32(newest, 20) == 0, "reserved bytes");
  for (std::size_t i = u32(newest, 12) == kWithLog ? 104 : 64; i < 4088; ++i)
    require(newest[i] == 0, "reserved bytes");
  return newest;
}

/// Fields one after another.
class Fields {
 public:
  explicit Fields(Bytes bytes) : bytes_(std::move(bytes)) {}
  std::uint64_t take(int size) {
    const std::uint64_t value = number(bytes_, at_, size);
    at_ += static_cast<std::size_t>(size);
    return value;
  }
  std::uint32_t take_u32() { return static_cast<std::uint32_t>(take(4)); }
  std::string take_text() {
    const std::size_t length = take_u32();
    require(length <= 65536 && length <= bytes_.size() - at_, "length of a text");
    const auto begin = bytes_.begin() + static_cast<std::ptrdiff_t>(at_);
    at_ += length;
    return {begin, begin + static_cast<std::ptrdiff_t>(length)};
  }
  bool at_end() const { return at_ == bytes_.size(); }

 private:
  Bytes bytes_;
  std::size_t at_ = 0;
};

/// What the description says of the base mesh.
struct BaseFigures {
  std::uint64_t vertices, edges, faces, border_edges, bytes, checksum;
};

Attribute read_attribute(Fields& fields, std::uint32_t base_level) {
  Attribute attribute;
  attribute.name = fields.take_text();
  attribute.number = fields.take_u32();
  attribute.type = static_cast<unsigned>(fields.take(1));
  attribute.components = static_cast<unsigned>(fields.take(1));
  attribute.base_bytes = fields.take(8);
  attribute.base_checksum = fields.take(8);
  attribute.pipeline = fields.take_text();
  const std::uint32_t levels = fields.take_u32(), ranges = fields.take_u32();
  for (std::uint32_t range = 0; range < ranges; ++range) {
    const std::uint32_t size = fields.take_u32(), representation = fields.take_u32();
    require(representation == 0, "representation");
    attribute.described.insert(attribute.described.end(), size,
                               {fields.take_text(), representation, 0});
  }
  require(attribute.described.size() == levels, "ranges of levels");
  for (Level& level : attribute.described) {
    level.generation = fields.take(8);
    require(fields.take_u32() == 0, "the number after a generation");
  }
  attribute.finest_level = base_level + levels;
  attribute.record_bytes = component_bytes(attribute.type) * attribute.components;
  return attribute;
}

/// The optional parts at the end of the description.
void read_optional(Store& store, Fields& fields, std::uint32_t flags) {
  if ((flags & 1) != 0)
    for (std::uint32_t rounded = fields.take_u32(); rounded > 0; --rounded)
      for (const int size : {4, 1, 8, 8, 8, 8}) fields.take(size);
  if ((flags & 2) != 0)
    for (std::uint32_t texts = fields.take_u32(); texts > 0; --texts) {
      const std::string name = fields.take_text();
      require(store.texts.empty() || store.texts.rbegin()->first < name, "order of texts");
      store.texts[name] = fields.take_text();
    }
  if ((flags & 4) != 0)
    for (std::uint32_t attributes = fields.take_u32(); attributes > 0; --attributes) {
      FaceAttribute attribute;
      attribute.name = fields.take_text();
      attribute.number = fields.take_u32();
      attribute.type = static_cast<unsigned>(fields.take(1));
      require(attribute.type >= 1 && attribute.type <= 10, "type of a face attribute");
      attribute.checksum = fields.take(8);
      store.face_attributes.push_back(attribute);
    }
}

/// Edges whose slots are in files of their own, and where the entries of their blocks are.
struct Shard {
  std::size_t first = 0, after = 0;
  std::string suffix;   ///< of the names of its files
  bool shared = false;  ///< one file has all levels of an attribute
  Bytes tables;
  std::size_t entry = 0;  ///< where the next level's entries begin in `tables`
  std::uint64_t checksum = 0;
};

std::vector<Shard> read_shards(Fields& fields, std::uint64_t edges) {
  std::vector<Shard> shards(fields.take_u32());
  for (std::size_t i = 0; i < shards.size(); ++i) {
    shards[i].first = fields.take_u32();
    require(i == 0 ? shards[i].first == 0 : shards[i].first > shards[i - 1].first, "first edge");
    require(shards[i].first < edges, "first edge");
    if (i > 0) shards[i - 1].after = shards[i].first;
    shards[i].suffix = fmt::format(".shard{}", i);
    shards[i].checksum = fields.take(8);
  }
  require(!shards.empty(), "number of shards");
  shards.back().after = edges;
  return shards;
}

/// `shards` stays empty if the levels are in one piece.
BaseFigures read_description(Store& store, Bytes description, std::uint32_t flags, bool in_shards,
                             std::vector<Shard>& shards) {
  Fields fields(std::move(description));
  BaseFigures base{};
  base.vertices = fields.take(8);
  base.edges = fields.take(8);
  base.faces = fields.take(8);
  base.border_edges = fields.take(8);
  store.block_bytes = fields.take(8);
  base.bytes = fields.take(8);
  base.checksum = fields.take(8);
  store.base_level = fields.take_u32();
  store.next_attribute_number = fields.take_u32();
  store.backend = fields.take_text();
  store.pipeline = fields.take_text();
  store.layout = fields.take_text();
  store.scheme = fields.take_text();
  store.program = fields.take_text();
  store.limit = (fields.take(1) & 1) != 0;
  store.precision = static_cast<std::uint8_t>(fields.take(1));
  const std::uint32_t attributes = fields.take_u32();
  for (std::uint32_t i = 0; i < attributes; ++i)
    store.attributes.push_back(read_attribute(fields, store.base_level));
  read_optional(store, fields, flags);
  if (in_shards) shards = read_shards(fields, base.edges);
  require(fields.at_end(), "end of the description");
  return base;
}

/// Number i of `count` numbers of `size` bytes whose planes begin at `offset`.
std::uint64_t plane_number(const Bytes& content, std::size_t offset, std::size_t count,
                           std::size_t size, std::size_t i) {
  std::uint64_t value = 0;
  for (std::size_t plane = size; plane-- > 0;)
    value = value << 8 | content.at(offset + plane * count + i);
  return value;
}
/// What was stored as 2 d for d >= 0 and as -2 d - 1 for d < 0.
std::uint64_t signed_difference(std::uint64_t stored) {
  return stored % 2 == 0 ? stored / 2 : 0 - (stored / 2 + 1);
}
std::uint64_t cut_to(std::size_t bytes, std::uint64_t number) {
  return bytes == 8 ? number : number & ((std::uint64_t{1} << (8 * bytes)) - 1);
}
/// The number with this place among all numbers of its type.
template <class Number, class Word>
Number float_at(std::uint64_t place) {
  constexpr Word kSign = Word{1} << (8 * sizeof(Word) - 1);
  auto bits = static_cast<Word>(place);
  bits = (bits & kSign) != 0 ? bits - kSign : ~bits;
  Number number;
  std::memcpy(&number, &bits, sizeof number);
  return number;
}
template <class Number, class Word>
std::uint64_t place_of_float(Number number) {
  constexpr Word kSign = Word{1} << (8 * sizeof(Word) - 1);
  Word bits;
  std::memcpy(&bits, &number, sizeof bits);
  return (bits & kSign) != 0 ? static_cast<Word>(~bits) : bits + kSign;
}

/// The records in a file of fewer bytes.
Bytes unpacked_base(const Store& store, const Attribute& attribute) {
  const std::size_t count = store.positions.size(), width = component_bytes(attribute.type),
                    size = count * attribute.record_bytes;
  Bytes content(size), records(size);
  require(ZSTD_findFrameCompressedSize(attribute.base.data(), attribute.base.size()) ==
                  attribute.base.size() &&
              ZSTD_getFrameContentSize(attribute.base.data(), attribute.base.size()) == size &&
              ZSTD_decompress(content.data(), size, attribute.base.data(), attribute.base.size()) ==
                  size,
          "frame of base records");
  const bool is_float32 = attribute.type == 1, is_float64 = attribute.type == 2;
  const bool follows =
      attribute.name == "position" && attribute.components == 3 && (is_float32 || is_float64);
  for (std::size_t c = 0; c < attribute.components; ++c) {
    std::uint64_t word = 0;
    for (std::size_t v = 0; v < count; ++v) {
      if (follows)
        word = is_float32
                   ? place_of_float<float, std::uint32_t>(static_cast<float>(store.positions[v][c]))
                   : place_of_float<double, std::uint64_t>(store.positions[v][c]);
      const std::uint64_t d = plane_number(content, c * width * count, count, width, v);
      word = cut_to(width, word + signed_difference(d));
      unsigned char* const to = &records[v * attribute.record_bytes + c * width];
      if (is_float32) {
        const auto number = float_at<float, std::uint32_t>(word);
        std::memcpy(to, &number, 4);
      } else if (is_float64) {
        const auto number = float_at<double, std::uint64_t>(word);
        std::memcpy(to, &number, 8);
      } else {
        std::memcpy(to, &word, width);
      }
    }
  }
  return records;
}

void read_base_mesh(Store& store, const std::filesystem::path& path, const BaseFigures& base) {
  const Bytes bytes = read_file(path);
  require(bytes.size() == base.bytes, "size of base.mesh");
  require(XXH3_64bits(bytes.data(), bytes.size()) == base.checksum, "checksum of base.mesh");
  require(starts_with(bytes, "plaitmsh") && u32(bytes, 8) == 3, "header of base.mesh");
  const std::uint64_t vertex_count = u64(bytes, 16), face_count = u64(bytes, 24);
  require(vertex_count == base.vertices && face_count == base.faces, "V, F");
  const std::uint32_t form = u32(bytes, 32);
  const auto exponent = static_cast<std::int32_t>(u32(bytes, 36));
  require(
      form == 3 ? exponent >= -1000 && exponent <= 900 : (form == 1 || form == 2) && exponent == 0,
      "form of positions");
  const std::size_t width = form == 2 ? 8 : 4;
  std::size_t frame = 40;
  const auto take_frame = [&](std::size_t size) {
    Bytes content(size);
    const std::size_t length = ZSTD_findFrameCompressedSize(&bytes.at(frame), bytes.size() - frame);
    require(ZSTD_getFrameContentSize(&bytes[frame], bytes.size() - frame) == size,
            "stated size of base.mesh");
    require(ZSTD_decompress(content.data(), size, &bytes[frame], length) == size,
            "frame of base.mesh");
    frame += length;
    return content;
  };
  Bytes content = take_frame((4 + 3 * width) * vertex_count + 12 * face_count);
  // Number i of `count` numbers of `size` bytes whose planes begin at `offset`.
  const auto in_planes = [&](std::size_t offset, std::size_t count, std::size_t size,
                             std::size_t i) {
    return plane_number(content, offset, count, size, i);
  };
  const std::size_t codes = 0, numbers = 12 * face_count, coordinates = numbers + 4 * vertex_count;
  std::vector<std::uint32_t> named;
  for (std::size_t f = 0; f < face_count; ++f) {
    std::array<std::uint32_t, 3> face{};
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint64_t code = in_planes(codes, 3 * face_count, 4, 3 * f + i);
      if (code == 0) {
        const std::uint64_t d = in_planes(numbers, vertex_count, 4, named.size());
        const std::uint64_t before = named.empty() ? 0 : named.back();
        named.push_back(
            static_cast<std::uint32_t>(d % 2 == 0 ? before + d / 2 : before - (d + 1) / 2));
        face[i] = named.back();
      } else {
        face[i] = code <= 3 ? store.faces.at(f - 1)[code - 1] : named.at(named.size() + 3 - code);
      }
    }
    store.faces.push_back(face);
  }
  require(named.size() == vertex_count, "vertices that faces name");
  store.positions.resize(vertex_count);
  for (std::size_t i = 0; i < 3; ++i) {
    std::uint64_t word = 0;
    for (std::size_t place = 0; place < vertex_count; ++place) {
      const std::uint64_t d =
          in_planes(coordinates + i * width * vertex_count, vertex_count, width, place);
      word = cut_to(width, word + signed_difference(d));
      double& x = store.positions[named[place]][i];
      if (form == 1)
        x = float_at<float, std::uint32_t>(word);
      else if (form == 2)
        x = float_at<double, std::uint64_t>(word);
      else
        x = std::ldexp(static_cast<std::int32_t>(word), exponent);
    }
  }
  store.input_vertex_count = u32(bytes, 12) == 0 ? vertex_count : u32(bytes, 12);
  if (u32(bytes, 12) != 0) content = take_frame(4 * vertex_count + 4 * face_count);
  require(frame == bytes.size(), "end of base.mesh");
  // Entry after entry, each from the one before.
  const auto entries = [&](std::size_t offset, std::size_t count, std::uint32_t step) {
    std::vector<std::uint32_t> result;
    for (std::size_t i = 0; i < count; ++i) {
      if (u32(bytes, 12) == 0) {
        result.push_back(static_cast<std::uint32_t>(i) * step);
        continue;
      }
      const std::uint64_t d = in_planes(offset, count, 4, i), before = i == 0 ? 0 : result.back();
      result.push_back(
          static_cast<std::uint32_t>(d % 2 == 0 ? before + d / 2 : before - (d + 1) / 2));
    }
    return result;
  };
  store.input_vertices = entries(0, vertex_count, 1);
  store.input_faces = entries(4 * vertex_count, face_count, 2);
}

void number_edges(Store& store, const BaseFigures& base) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> known;  // (lower, higher)
  for (std::uint32_t f = 0; f < store.faces.size(); ++f)
    for (const std::uint32_t side : {2u, 0u, 1u}) {  // ab, bc, ca
      const std::uint32_t from = store.faces[f][(side + 1) % 3],
                          to = store.faces[f][(side + 2) % 3];
      const auto [found, fresh] = known.try_emplace(std::minmax(from, to), store.edges.size());
      if (fresh) {
        store.edges.push_back({from, to, f, side});
        continue;
      }
      Edge& edge = store.edges[found->second];
      require(edge.is_border() && edge.start == to, "two faces, opposite directions");
      edge.other_face = f;
      edge.other_side = side;
      if (from < to) edge = {from, to, f, side, edge.own_face, edge.own_side};
    }
  std::uint64_t border = 0;
  for (const Edge& edge : store.edges)
    if (edge.is_border()) ++border;
  require(store.edges.size() == base.edges && border == base.border_edges, "edges, border");
}

/// The change log, and what its records say.
struct ChangeLog {
  struct Block {
    std::uint64_t offset, checksum;
  };
  struct Piece {
    std::uint64_t attribute, first;
    Bytes bytes;
  };
  std::uint64_t described = 0;
  Bytes file;
  /// Attribute, level and number of a block.
  std::map<std::tuple<std::uint64_t, std::uint64_t, std::uint64_t>, Block> blocks;
  std::vector<Piece> pieces;
};

ChangeLog read_change_log(const Bytes& manifest, const std::filesystem::path& directory) {
  ChangeLog log;
  std::uint64_t version = u64(manifest, 40);
  log.described = version;
  if (u32(manifest, 12) != kWithLog) return log;
  log.described = u64(manifest, 64);
  log.file = read_file(directory / fmt::format("changes.{}", u64(manifest, 72)));
  require(log.file.size() >= u64(manifest, 80), "size of the change log");
  log.file.resize(u64(manifest, 80));
  std::uint64_t at = u64(manifest, 88), checksum = u64(manifest, 96);
  // From the newest record to the oldest: what a newer one says stands.
  for (; version > log.described; --version) {
    require(at % 4096 == 0 && starts_with(Bytes(log.file.begin() + static_cast<std::ptrdiff_t>(at),
                                                log.file.end()),
                                          "plaitchg"),
            "place of a record");
    require(u32(log.file, at + 8) == 1 && u64(log.file, at + 16) == version, "head of a record");
    const std::uint64_t blocks = u64(log.file, at + 40), pieces = u64(log.file, at + 48);
    const std::uint64_t end = at + 56 + 32 * blocks + 40 * pieces;
    require(XXH3_64bits(&log.file[at], end - at) == checksum && u64(log.file, end) == checksum,
            "checksum of a record");
    for (std::uint64_t block = 0; block < blocks; ++block) {
      const std::uint64_t entry = at + 56 + 32 * block;
      log.blocks.insert({{u32(log.file, entry), u32(log.file, entry + 4), u64(log.file, entry + 8)},
                         {u64(log.file, entry + 16), u64(log.file, entry + 24)}});
    }
    for (std::uint64_t piece = 0; piece < pieces; ++piece) {
      const std::uint64_t entry = end - 40 * (pieces - piece);
      const auto from = log.file.begin() + static_cast<std::ptrdiff_t>(u64(log.file, entry + 24));
      const Bytes bytes(from, from + static_cast<std::ptrdiff_t>(u64(log.file, entry + 16)));
      require(XXH3_64bits(bytes.data(), bytes.size()) == u64(log.file, entry + 32),
              "checksum of a piece of records");
      log.pieces.insert(log.pieces.begin(),
                        {u32(log.file, entry), u64(log.file, entry + 8), bytes});
    }
    checksum = u64(log.file, at + 32);
    at = u64(log.file, at + 24);
  }
  require(at == 0, "the first record");
  return log;
}

/// [edge] where its slot begins in level k from the base level on, and the total at the end.
std::vector<std::uint64_t> offsets_of_slots(const Store& store, const Attribute& attribute,
                                            std::uint32_t k) {
  const std::uint64_t n = std::uint64_t{1} << (k - 1);
  std::vector<std::uint64_t> offsets;
  std::uint64_t border_before = 0;
  for (std::size_t e = 0; e <= store.edges.size(); ++e) {
    offsets.push_back((e * n * n - border_before * (n * (n - 1) / 2)) * attribute.record_bytes);
    if (e < store.edges.size() && store.edges[e].is_border()) ++border_before;
  }
  return offsets;
}

/// The bytes that raw levels 1 to k from the base level on take in the shard's shared file.
std::uint64_t bytes_of_levels(const Store& store, const Attribute& attribute, std::uint32_t k,
                              const Shard& shard) {
  std::uint64_t bytes = 0;
  for (std::uint32_t level = 1; level <= k; ++level) {
    const std::vector<std::uint64_t> offsets = offsets_of_slots(store, attribute, level);
    bytes += (offsets[shard.after] - offsets[shard.first] + 4095) / 4096 * 4096;
  }
  return bytes;
}

/// Reads one level; the entries of each shard begin at its `entry`, which moves behind them.
void read_level(Store& store, Attribute& attribute, std::uint32_t level,
                const std::filesystem::path& directory, std::vector<Shard>& shards,
                const ChangeLog& log) {
  const std::uint32_t k = level - store.base_level;
  const std::uint64_t n = std::uint64_t{1} << (k - 1), full = n * n * attribute.record_bytes;
  const std::vector<std::uint64_t> slot_offsets = offsets_of_slots(store, attribute, k);
  std::size_t slots = 1;  // in a block
  while (2 * slots * full <= store.block_bytes && slots < store.edges.size()) slots *= 2;

  const Level& described = attribute.described.at(k - 1);
  const bool compressed = store.backend == "compressed";
  Bytes& content = attribute.levels[level];
  std::uint64_t block = 0;  // numbered through all shards
  for (Shard& shard : shards) {
    const std::uint64_t origin = slot_offsets[shard.first];
    const Bytes& tables = shard.tables;
    std::size_t& entry = shard.entry;
    const Bytes level_file = read_file(
        directory / (shard.shared ? fmt::format("attribute{}.levels.{}{}", attribute.number,
                                                described.generation, shard.suffix)
                                  : fmt::format("attribute{}.level{:02}.{}{}", attribute.number,
                                                level, described.generation, shard.suffix)));
    std::uint64_t level_begin = 0;
    if (shard.shared && !compressed) {
      level_begin = bytes_of_levels(store, attribute, k - 1, shard);
      require(
          level_file.size() ==
              bytes_of_levels(store, attribute, attribute.finest_level - store.base_level, shard),
          "size of a file of several levels");
    } else if (!compressed) {
      require(level_file.size() == (slot_offsets[shard.after] - origin + 4095) / 4096 * 4096,
              "size of a level file");
    }
    for (std::size_t first = shard.first; first < shard.after;
         first += slots, ++block, entry += 24) {
      const std::uint64_t raw_offset = slot_offsets[first] - origin;
      const std::uint64_t raw_bytes =
          slot_offsets[std::min(first + slots, shard.after)] - origin - raw_offset;
      std::uint64_t offset = u64(tables, entry), stored_bytes = u32(tables, entry + 8),
                    checksum = u64(tables, entry + 16);
      std::uint32_t encoding = u16(tables, entry + 12), number = u16(tables, entry + 14);
      if (const auto changed = log.blocks.find({attribute.number, level, block});
          changed != log.blocks.end()) {
        offset = changed->second.offset;
        checksum = changed->second.checksum;
        stored_bytes = raw_bytes;
        encoding = number = 1;
      }
      require(number < (log.file.empty() ? 1u : 2u), "file of a block");
      const Bytes& file = number == 0 ? level_file : log.file;
      require(encoding <= (compressed ? 2 : 1), "encoding");
      ++store.blocks_of_encoding[encoding];
      if (encoding == 0) {
        require(offset == 0 && stored_bytes == 0 && checksum == 0, "never written");
        content.resize(content.size() + raw_bytes, 0);
        continue;
      }
      require(offset + stored_bytes <= file.size(), "extent");
      const auto at = file.begin() + static_cast<std::ptrdiff_t>(offset);
      const Bytes stored(at, at + static_cast<std::ptrdiff_t>(stored_bytes));
      require(block_checksum(store, attribute.number, level, block, stored) == checksum,
              "checksum of a block");
      if (number == 1)
        require(!compressed && encoding == 1 && offset % 4096 == 0, "a block in the change log");
      else if (compressed)
        require(offset % 512 == 0, "alignment");
      else
        require(offset == level_begin + raw_offset, "offset");
      if (encoding == 1) require(stored_bytes == raw_bytes, "raw size");
      const Bytes raw = encoding == 1 ? stored
                                      : decoded(described.pipeline, stored, raw_bytes,
                                                component_bytes(attribute.type));
      content.insert(content.end(), raw.begin(), raw.end());
    }
  }
}

/// What base.index has if it is there, from the mesh that base.mesh has.
void check_base_index(const Store& store, const std::filesystem::path& path,
                      const BaseFigures& base) {
  if (!std::filesystem::exists(path)) return;
  constexpr std::uint32_t kNone = 0xffffffff;
  Bytes arrays[8];
  for (const auto& position : store.positions)
    for (const double coordinate : position) {
      std::uint64_t bits;
      std::memcpy(&bits, &coordinate, 8);
      append(arrays[0], bits, 8);
    }
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> numbers;
  for (std::uint32_t e = 0; e < store.edges.size(); ++e) {
    const Edge& edge = store.edges[e];
    numbers[std::minmax(edge.start, edge.end)] = e;
    const std::uint32_t own = 3 * edge.own_face + edge.own_side,
                        other = edge.is_border() ? kNone : 3 * edge.other_face + edge.other_side;
    for (const std::uint32_t field : {edge.start, edge.end, own, other})
      append(arrays[3], field, 4);
    if (edge.is_border()) append(arrays[5], e, 4);
  }
  // [vertex] its corner, and the next corner's vertex; 0 after a border edge.
  std::vector<std::pair<std::uint64_t, std::uint32_t>> corners(store.positions.size(), {kNone, 0});
  for (std::uint32_t f = 0; f < store.faces.size(); ++f)
    for (std::uint32_t x = 0; x < 3; ++x) {
      const auto& face = store.faces[f];
      const std::uint32_t vertex = face[x], next = face[(x + 1) % 3], after = face[(x + 2) % 3];
      append(arrays[1], vertex, 4);
      append(arrays[2], numbers.at(std::minmax(next, after)), 4);
      const bool begins = store.edges[numbers.at(std::minmax(vertex, next))].is_border();
      corners[vertex] =
          std::min(corners[vertex], {begins ? 0 : 1 + std::uint64_t{next}, 3 * f + x});
    }
  for (const auto& corner : corners) append(arrays[4], corner.second, 4);
  bool vertices_differ = store.input_vertex_count != store.positions.size(), faces_differ = false;
  for (std::uint32_t v = 0; v < store.positions.size(); ++v)
    vertices_differ = vertices_differ || store.input_vertices[v] != v;
  for (std::uint32_t f = 0; f < store.faces.size(); ++f)
    faces_differ = faces_differ || store.input_faces[f] != 2 * f;
  if (vertices_differ)
    for (const std::uint32_t vertex : store.input_vertices) append(arrays[6], vertex, 4);
  if (faces_differ)
    for (const std::uint32_t face : store.input_faces) append(arrays[7], face, 4);

  Bytes file = {'p', 'l', 'a', 'i', 't', 'i', 'd', 'x'};
  append(file, 1, 4);
  append(file, (vertices_differ ? 1u : 0u) + (faces_differ ? 2u : 0u), 4);
  for (const std::uint64_t count :
       {store.positions.size(), store.edges.size(), store.faces.size(), arrays[5].size() / 4})
    append(file, count, 8);
  append(file, store.input_vertex_count, 8);
  append(file, base.checksum, 8);
  for (const Bytes& array : arrays)
    for (std::size_t page = 0; page < array.size(); page += 65536)
      append(file, XXH3_64bits(&array[page], std::min<std::size_t>(65536, array.size() - page)), 8);
  append(file, XXH3_64bits(file.data(), file.size()), 8);
  for (const Bytes& array : arrays) {
    file.resize((file.size() + 4095) / 4096 * 4096);
    file.insert(file.end(), array.begin(), array.end());
  }
  file.resize((file.size() + 4095) / 4096 * 4096);
  require(read_file(path) == file, "base.index");
}

}  // namespace

Store read_store(const std::filesystem::path& directory) {
  const Bytes manifest = read_manifest_slot(directory / "manifest");
  Store store;
  std::memcpy(store.uuid.data(), &manifest[24], 16);
  store.sequence = u64(manifest, 40);
  const ChangeLog log = read_change_log(manifest, directory);
  const Bytes version = read_file(directory / fmt::format("version.{}", log.described));
  require(version.size() == u64(manifest, 48), "size of the version");
  require(XXH3_64bits(version.data(), version.size()) == u64(manifest, 56),
          "checksum of the version");
  require(starts_with(version, "plaitver") && u32(version, 8) == 1 && u32(version, 12) == 0,
          "header of the version");
  const std::uint64_t described_bytes = u64(version, 16);
  require(described_bytes <= version.size() - 32, "size of the description");
  const auto begin = version.begin() + 32;
  const Bytes description(begin, begin + static_cast<std::ptrdiff_t>(described_bytes));
  require(XXH3_64bits(description.data(), description.size()) == u64(version, 24),
          "checksum of the description");
  const bool in_shards = (u32(manifest, 12) & kInShards) != 0,
             shared = (u32(manifest, 12) & kSharedFiles) != 0;
  std::vector<Shard> shards;
  const BaseFigures base =
      read_description(store, description, u32(manifest, 16), in_shards, shards);
  read_base_mesh(store, directory / "base.mesh", base);
  number_edges(store, base);
  check_base_index(store, directory / "base.index", base);

  if (!in_shards)
    shards = {{0, store.edges.size(), "", false, version, 32 + description.size(), 0}};
  for (std::size_t i = 0; in_shards && i < shards.size(); ++i) {
    Shard& shard = shards[i];
    shard.shared = shared;
    shard.tables = read_file(directory / fmt::format("version.{}.shard{}", store.sequence, i));
    require(XXH3_64bits(shard.tables.data(), shard.tables.size()) == shard.checksum,
            "checksum of the tables of a shard");
    require(starts_with(shard.tables, "plaitshd") && u32(shard.tables, 8) == 1 &&
                u32(shard.tables, 12) == i &&
                std::equal(store.uuid.begin(), store.uuid.end(), shard.tables.begin() + 16),
            "header of the tables of a shard");
    shard.entry = 32;
  }
  for (Attribute& attribute : store.attributes) {
    attribute.base =
        read_file(directory / fmt::format("attribute{}.base.{}", attribute.number, log.described));
    require(attribute.base.size() == attribute.base_bytes, "size of the base records");
    require(XXH3_64bits(attribute.base.data(), attribute.base.size()) == attribute.base_checksum,
            "checksum of the base records");
    if (attribute.base_bytes < store.positions.size() * attribute.record_bytes)
      attribute.base = unpacked_base(store, attribute);
    require(attribute.base.size() == store.positions.size() * attribute.record_bytes,
            "size of the base records");
    for (const auto& piece : log.pieces)
      if (piece.attribute == attribute.number) {
        require(piece.first + piece.bytes.size() <= attribute.base.size(), "a piece of records");
        std::ranges::copy(piece.bytes,
                          attribute.base.begin() + static_cast<std::ptrdiff_t>(piece.first));
      }
    for (std::uint32_t level = store.base_level + 1; level <= attribute.finest_level; ++level)
      read_level(store, attribute, level, directory, shards, log);
  }
  for (FaceAttribute& attribute : store.face_attributes) {
    attribute.numbers =
        read_file(directory / fmt::format("attribute{}.faces.{}", attribute.number, log.described));
    require(attribute.numbers.size() == store.faces.size() * component_bytes(attribute.type),
            "size of a face attribute");
    require(XXH3_64bits(attribute.numbers.data(), attribute.numbers.size()) == attribute.checksum,
            "checksum of a face attribute");
  }
  for (const Shard& shard : shards)
    require(shard.entry == shard.tables.size(), "end of the block tables");
  if (in_shards) require(version.size() == 32 + description.size(), "end of the version");
  return store;
}

Place place_of(const Store& store, const Edge& edge, std::uint32_t k, std::int64_t row,
               std::int64_t column) {
  const std::int64_t size = std::int64_t{1} << k, n = size / 2;
  std::uint32_t face = edge.own_face, side = edge.own_side;
  if (size - (2 * row + 1) - (2 * column + 1) < 0) {
    face = edge.other_face;
    side = edge.other_side;
    row = n - 1 - row;
    column = n - 1 - column;
  }
  const auto& corners = store.faces.at(face);
  return {{corners[(side + 1) % 3], corners[(side + 2) % 3], corners[side]},
          {2 * row + 1, 2 * column + 1, size - (2 * row + 1) - (2 * column + 1)}};
}

}  // namespace format
