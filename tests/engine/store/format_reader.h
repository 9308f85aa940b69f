// tests/engine/store/format_reader.h: a reader of stores written from docs/format.md alone: it
// includes nothing of the library.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace format {

using Bytes = std::vector<unsigned char>;

struct Edge {
  std::uint32_t start, end;
  std::uint32_t own_face, own_side;
  std::uint32_t other_face = 0xffffffff, other_side = 0;  ///< no other face on a border
  bool is_border() const { return other_face == 0xffffffff; }
};

struct Level {
  std::string pipeline;
  std::uint32_t representation;
  std::uint64_t generation;
};

struct Attribute {
  std::string name, pipeline;
  std::uint32_t number, finest_level;
  std::uint64_t base_bytes, base_checksum;
  std::vector<Level> described;  ///< [level - base level - 1]
  unsigned type, components;
  std::size_t record_bytes;
  Bytes base;
  std::map<std::uint32_t, Bytes> levels;  ///< slots one after another, decoded
};

struct FaceAttribute {
  std::string name;
  std::uint32_t number;
  unsigned type;
  std::uint64_t checksum;
  Bytes numbers;
};

struct Store {
  std::array<unsigned char, 16> uuid;
  std::uint64_t sequence, block_bytes;
  std::uint32_t base_level, next_attribute_number;
  std::string backend, pipeline, layout, scheme, program;
  bool limit;
  std::uint8_t precision;
  std::vector<std::array<double, 3>> positions;
  std::vector<std::array<std::uint32_t, 3>> faces;
  std::vector<Edge> edges;
  std::vector<Attribute> attributes;
  std::map<std::string, std::string> texts;
  std::vector<FaceAttribute> face_attributes;
  std::uint64_t input_vertex_count;
  std::vector<std::uint32_t> input_vertices;  ///< [vertex]
  std::vector<std::uint32_t> input_faces;     ///< [face] twice the face, plus 1 if it was turned
  std::array<std::uint64_t, 3> blocks_of_encoding{};  ///< never written, raw, encoded
};

/// Throws std::runtime_error for whatever is not as the document says.
Store read_store(const std::filesystem::path& directory);

/// Where a record of a slot lies: weights of 2^k at three base vertices.
struct Place {
  std::array<std::uint32_t, 3> vertices;
  std::array<std::int64_t, 3> weights;
};
/// `k` is the level counted from the base mesh.
Place place_of(const Store& store, const Edge& edge, std::uint32_t k, std::int64_t row,
               std::int64_t column);

}  // namespace format
