// tests/fuzz/make_corpora.cpp: writes the seeds of all targets, the same each time. The build runs
// it.
//
//   make_corpora DIRECTORY
#include <zlib.h>
#include <zstd.h>

#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "compressed/block_coder.h"
#include "format/base_mesh_file.h"
#include "format/base_records_file.h"
#include "format/checksum.h"
#include "format/manifest.h"
#include "format/packed_mesh.h"
#include "format/version_description.h"
#include "format/version_file.h"
#include "plait/extend/level_geometry.h"
#include "plait/registry.h"

using namespace plait;

namespace {

std::filesystem::path corpora;

void seed(const char* target, const char* name, const std::string& bytes) {
  std::filesystem::create_directories(corpora / target);
  std::ofstream file(corpora / target / name, std::ios::binary);
  file << bytes;
  file.exceptions(std::ios::failbit);
  file.close();
}

template <class Number>
std::string number(Number value, bool big_endian = false) {
  std::string bytes(reinterpret_cast<const char*>(&value), sizeof(Number));
  return big_endian ? std::string(bytes.rbegin(), bytes.rend()) : bytes;
}

std::string text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text));
}

std::string zstd(const std::string& bytes, bool checksum = false) {
  std::string result(ZSTD_compressBound(bytes.size()), '\0');
  ZSTD_CCtx* const context = ZSTD_createCCtx();
  ZSTD_CCtx_setParameter(context, ZSTD_c_checksumFlag, checksum ? 1 : 0);
  result.resize(ZSTD_compress2(context, result.data(), result.size(), bytes.data(), bytes.size()));
  ZSTD_freeCCtx(context);
  return result;
}

std::string gzip(const std::string& bytes, bool with_names = false) {
  std::string result(bytes.size() + 200, '\0');
  z_stream stream{};
  deflateInit2(&stream, 9, Z_DEFLATED, MAX_WBITS + 16, 8, Z_DEFAULT_STRATEGY);
  gz_header header{};
  std::string name = "mesh.ply", comment = "a comment", extra("ab\4\0more", 8);
  header.name = reinterpret_cast<Bytef*>(name.data());
  header.comment = reinterpret_cast<Bytef*>(comment.data());
  header.extra = reinterpret_cast<Bytef*>(extra.data());
  header.extra_len = static_cast<uInt>(extra.size());
  if (with_names) deflateSetHeader(&stream, &header);
  std::string input = bytes;
  stream.next_in = reinterpret_cast<Bytef*>(input.data());
  stream.avail_in = static_cast<uInt>(input.size());
  stream.next_out = reinterpret_cast<Bytef*>(result.data());
  stream.avail_out = static_cast<uInt>(result.size());
  deflate(&stream, Z_FINISH);
  result.resize(stream.total_out);
  deflateEnd(&stream);
  return result;
}

const std::vector<std::vector<double>> kPoints = {{1, 0, 0},  {0, 1, 0}, {-1, 0, 0},
                                                  {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
const std::vector<std::vector<std::uint32_t>> kFaces = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4},
                                                        {1, 0, 5}, {2, 1, 5}, {3, 2, 5}, {0, 3, 5}};

std::string binary_ply(bool big_endian) {
  std::string bytes = std::string("ply\nformat binary_") + (big_endian ? "big" : "little") +
                      "_endian 1.0\nelement vertex 6\nproperty float x\nproperty float y\n"
                      "property float z\nelement face 8\n"
                      "property list uchar int vertex_indices\nend_header\n";
  for (const auto& point : kPoints)
    for (const double x : point) bytes += number(static_cast<float>(x), big_endian);
  for (const auto& face : kFaces) {
    bytes += '\3';
    for (const std::uint32_t vertex : face) bytes += number(vertex, big_endian);
  }
  return bytes;
}

/// Lists among the properties of both elements, another element, a polygon.
std::string binary_ply_with_lists() {
  std::string bytes =
      "ply\r\nformat binary_little_endian 1.0\r\nobj_info none\r\nelement face 1\r\n"
      "property uchar red\r\nproperty list short uint vertex_index\r\nelement edge 1\r\n"
      "property list uint double weights\r\nelement vertex 4\r\nproperty list char char tags\r\n"
      "property double z\r\nproperty short x\r\nproperty ushort y\r\nend_header\r\n";
  bytes += '\xff' + number(std::int16_t{4});
  for (std::uint32_t vertex = 0; vertex < 4; ++vertex) bytes += number(vertex);
  bytes += number(std::uint32_t{2}) + number(1.5) + number(2.5);
  for (int vertex = 0; vertex < 4; ++vertex)
    bytes += std::string("\2ab") + number(0.25) +
             number(static_cast<std::int16_t>(vertex % 3 == 0 ? -1 : 1)) +
             number(static_cast<std::uint16_t>(vertex / 2));
  return bytes;
}

void seed_meshes() {
  std::string ply =
      "ply\nformat ascii 1.0\ncomment an octahedron\nelement vertex 6\n"
      "property float x\nproperty float y\nproperty float z\nelement face 8\n"
      "property list uchar int vertex_indices\nend_header\n";
  std::string obj = "# an octahedron\no shape\n", off = "OFF\n# an octahedron\n6 8 12\n";
  for (const auto& p : kPoints) {
    char line[64];
    std::snprintf(line, sizeof line, "%g %g %g\n", p[0], p[1], p[2]);
    ply += line;
    off += line;
    obj += std::string("v ") + line;
  }
  for (const auto& f : kFaces) {
    char line[64];
    std::snprintf(line, sizeof line, "3 %u %u %u\n", f[0], f[1], f[2]);
    ply += line;
    off += line;
    std::snprintf(line, sizeof line, "f %u %u/1 %u//2\n", f[0] + 1, f[1] + 1, f[2] + 1);
    obj += line;
  }
  seed("ply", "ascii", ply);
  seed("ply", "ascii_cr",
       "ply\rformat ascii 1.0\relement vertex 3\rproperty float x\r"
       "property double y\rproperty int z\relement face 1\r"
       "property list uchar uchar vertex_index\rend_header\r"
       "0 0 0\r1e-2 0 0\r0 +1.5E3 0\r3 0 1 2\r");
  seed("ply", "little_endian", binary_ply(false));
  seed("ply", "big_endian", binary_ply(true));
  seed("ply", "lists", binary_ply_with_lists());
  std::string high_index = binary_ply(false);
  high_index.back() = '\1';
  seed("ply", "index_too_high", high_index);
  seed("ply", "gzip", gzip(ply));
  seed("ply", "zstd", zstd(binary_ply(false)));
  seed("obj", "octahedron", obj);
  seed("obj", "statements",
       "mtllib a.mtl\nv 0 0 0 1\nv 1 0 0 0.5 0.5 0.5\r\nv 1 1 \\\n 0\n"
       "vt 0 0\nvn 0 0 1\ng one two\nusemtl red\ns off\nl 1 2\n"
       "f -3/1/1 -2/1/1 -1/1/1 4\nv 0 1 0\n");
  seed("obj", "gzip", gzip(obj));
  seed("off", "octahedron", off);
  seed("off", "colours",
       "COFF\n4 1 0\n0 0 0 1 1 1 1\n1 0 0 1 1 1 1\n1 1 0 1 1 1 1\n"
       "0 1 0 1 1 1 1\n4 0 1 2 3 0.5 0.5 0.5\n");
  seed("off", "no_keyword", "3 1 3 # counts\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  seed("off", "zstd", zstd(off));

  seed("compressed_input", "gzip", gzip(ply));
  seed("compressed_input", "gzip_names", gzip(off, true));
  seed("compressed_input", "gzip_two_members", gzip("one") + gzip("two"));
  std::string wrong_length = gzip("one");
  wrong_length.back() = '\1';
  seed("compressed_input", "gzip_wrong_length", wrong_length);
  std::string reserved_flag = gzip("two");
  reserved_flag[3] = 0x40;
  seed("compressed_input", "gzip_reserved_flag", gzip("one") + reserved_flag);
  seed("compressed_input", "zstd", zstd(ply));
  seed("compressed_input", "zstd_checksum", zstd(off, true));
  seed("compressed_input", "zstd_skippable",
       std::string("\x53\x2a\x4d\x18\3\0\0\0abc", 11) + zstd("one") + zstd("", true));
  // A window of 1 KiB, a raw block of two bytes, a repeated byte, the end.
  seed("compressed_input", "zstd_blocks",
       std::string("\x28\xb5\x2f\xfd\0\0\x10\0\0ab\x42\0\0c\1\0\0", 18));
}

void seed_base_meshes() {
  IndexedMesh octahedron;
  for (const auto& p : kPoints) octahedron.positions.push_back({p[0], p[1], p[2]});
  for (const auto& f : kFaces) octahedron.faces.push_back({f[0], f[1], f[2]});
  const BaseMesh mesh = BaseMesh::build(std::move(octahedron), "octahedron");
  const PositionWords words = words_of(mesh.positions());
  const std::vector<std::byte> content = pack_mesh(mesh, words);
  const auto text = [](std::span<const std::byte> bytes) {
    return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  };
  const auto counts = [&](bool is_content, std::uint32_t vertices, std::uint32_t faces) {
    return number(static_cast<std::uint8_t>(is_content)) + number(vertices) + number(faces) +
           (is_content ? number(static_cast<std::uint32_t>(words.form)) +
                             number(static_cast<std::uint32_t>(words.exponent))
                       : std::string());
  };
  const std::string file = text(base_mesh_file(6, 8, words, content));
  seed("base_mesh_file", "octahedron", counts(true, 6, 8) + text(content));
  seed("base_mesh_file", "file", counts(false, 6, 8) + file);
  seed("base_mesh_file", "many_vertices", counts(true, 0x80000000, 8) + text(content));
  seed("base_mesh_file", "triangle",
       counts(true, 3, 1) + std::string(12, '\0') + std::string("\0\2\2\0\0\0\0\0\0\0\0\0", 12) +
           std::string(36, '\0'));
  const auto in_form = [](PositionForm form, std::uint32_t exponent, std::size_t coordinates) {
    return number(std::uint8_t{1}) + number(std::uint32_t{3}) + number(std::uint32_t{1}) +
           number(static_cast<std::uint32_t>(form)) + number(exponent) + std::string(12, '\0') +
           std::string("\0\2\2\0\0\0\0\0\0\0\0\0", 12) + std::string(coordinates, '\7');
  };
  seed("base_mesh_file", "float32", in_form(PositionForm::kFloat32, 0, 36));
  seed("base_mesh_file", "float64", in_form(PositionForm::kFloat64, 0, 72));
  seed("base_mesh_file", "whole", in_form(PositionForm::kWhole, 0xfffffc18, 36));
  seed("base_mesh_file", "no_form", in_form(PositionForm{4}, 0, 36));
  seed("base_mesh_file", "vertex_twice", counts(true, 3, 1) + std::string(12 + 12 + 36, '\0'));
}

void seed_base_records() {
  const auto head = [](std::uint8_t type, bool is_position, std::uint8_t components,
                       std::uint8_t vertices) {
    return number(static_cast<std::uint8_t>(type - 1)) +
           number(static_cast<std::uint8_t>(is_position)) +
           number(static_cast<std::uint8_t>(components - 1)) +
           number(static_cast<std::uint8_t>(vertices - 1));
  };
  const auto file = [](const AttributeSchema& schema, std::span<const Vector3<double>> positions,
                       std::size_t vertices) {
    const std::vector<std::byte> records(vertices * schema.record_bytes());
    const std::vector<std::byte> packed = encode_base_records(schema, records, positions);
    return std::string(reinterpret_cast<const char*>(packed.data()), packed.size());
  };
  const std::vector<Vector3<double>> positions(200);
  const AttributeSchema position = {"position", ComponentType::kFloat32, 3},
                        wide = {"other", ComponentType::kFloat64, 2},
                        label = {"other", ComponentType::kUint8, 1};
  const std::string frame = file(position, positions, 200);
  seed("base_records_file", "positions", head(1, true, 3, 200) + frame);
  seed("base_records_file", "wide", head(2, false, 2, 200) + file(wide, {}, 200));
  seed("base_records_file", "labels", head(7, false, 1, 200) + file(label, {}, 200));
  seed("base_records_file", "of_others", head(1, false, 3, 200) + frame);
  seed("base_records_file", "raw", head(7, false, 1, 5) + std::string("abcde"));
}

void seed_manifests() {
  Manifest manifest;
  manifest.sequence = 7;
  manifest.version_bytes = 200;
  const std::string odd = text_of(encode_manifest(manifest));
  seed("manifest", "one_slot", odd);
  manifest.sequence = 8;
  manifest.version_checksum = 12;
  const std::string even = text_of(encode_manifest(manifest));
  seed("manifest", "two_slots", even + odd);
}

void seed_descriptions() {
  const auto file = [](const VersionDescription& version) {
    return text_of(encode_version_file(encode_description(version), {}));
  };
  VersionDescription version;
  version.vertex_count = 6;
  version.edge_count = 12;
  version.face_count = 8;
  version.block_bytes = 4096;
  version.base_mesh_bytes = 272;
  version.backend = "pread";
  version.provenance.layout = "hilbert";
  seed("version_description", "no_attributes", file(version));
  version.backend = "compressed";
  version.pipeline = "shuffle,zstd:19";
  version.provenance = {"loop", true, ComponentType::kFloat64, "hilbert", 1, "0.1.0"};
  version.next_attribute_number = 4;
  const LevelRecord raw{"none", Representation::kValues, 3},
      coded{"lz4", Representation::kValues, 7};
  const auto add = [&](AttributeSchema schema, std::uint32_t number, const char* pipeline,
                       std::vector<LevelRecord> levels) {
    AttributeRecord& attribute = version.attributes.emplace_back();
    attribute.schema = std::move(schema);
    attribute.number = number;
    attribute.base_bytes = version.vertex_count * attribute.schema.record_bytes();
    attribute.base_checksum = 11 + number;
    attribute.pipeline = pipeline;
    attribute.levels = std::move(levels);
  };
  add({"position", ComponentType::kFloat32, 3}, 0, "shuffle,zstd:19", {raw, raw, coded});
  add({"normal-2_x", ComponentType::kFloat64, 3}, 3, "none", {});
  add({"wide", ComponentType::kUint16, 255}, 1, "lz4", {coded});
  const std::string full = file(version);
  seed("version_description", "three_attributes", full);
  seed("version_description", "cut", full.substr(0, full.size() / 2));
  seed("version_description", "more", full + std::string(100, 'x'));
  version.shards = {{0, 5}, {3, 6}, {7, 0xffff'ffff'ffff'ffff}};
  const std::string shards = file(version);
  seed("version_description", "shards", shards);
  seed("version_description", "shards_cut", shards.substr(0, shards.size() - 5));
  version.shards = {{0, 5}, {7, 6}, {3, 7}};
  seed("version_description", "shards_descend", file(version));
  version.shards.clear();
  version.attributes[0].levels[1].representation = Representation{1};
  seed("version_description", "representation_unknown", file(version));
}

void seed_block_tables() {
  struct Shape {
    std::uint16_t edges;
    std::uint8_t borders, level, record, block;  ///< as the target takes them
  };
  const auto file = [](const std::vector<Shape>& shapes) {
    std::string levels(1, static_cast<char>(shapes.size())), entries;
    for (const Shape& shape : shapes) {
      levels += number(shape);
      std::vector<EdgeId> borders;
      for (EdgeId edge = 0; edge < shape.borders; ++edge) borders.push_back(edge);
      const LevelGeometry geometry(SlotShapes(shape.edges, EdgeSet(borders)),
                                   BaseRelativeLevel(1 + shape.level), 1 + 8u * shape.record,
                                   std::uint64_t{4096} << shape.block);
      for (std::uint64_t block = 0; block < geometry.block_count(); ++block) {
        const auto raw_bytes = static_cast<std::uint32_t>(geometry.block_bytes(block));
        const BlockEntry kinds[] = {
            {},
            {0, 0, BlockEncoding::kPredicted, 97},
            {geometry.block_offset(block), raw_bytes, BlockEncoding::kRaw, 99},
            {512 * block, raw_bytes / 2, BlockEncoding::kEncoded, 98}};
        entries += number(kinds[block % 4]);
      }
    }
    return levels + entries;
  };
  seed("block_tables", "no_level", file({}));
  seed("block_tables", "closed", file({{12, 0, 0, 1, 0}, {12, 0, 5, 1, 0}}));
  std::string damaged = file({{12, 0, 0, 1, 0}});
  damaged[damaged.size() - 12] = '\7';
  seed("block_tables", "encoding_unknown", damaged);
  seed("block_tables", "border", file({{40, 7, 3, 2, 0}, {40, 40, 6, 0, 1}, {5, 4, 4, 3, 2}}));
}

void seed_codecs() {
  std::string smooth, noise;
  std::uint32_t state = 1;
  for (int i = 0; i < 200; ++i) smooth += number(1.0f + static_cast<float>(i) / 256);
  for (int i = 0; i < 300; ++i) {
    state = state * 1664525u + 1013904223u;  // any generator will do
    noise += static_cast<char>(state >> 24);
  }
  const char* const codecs[] = {"none", "lz4", "zstd", "zstd:-5", "zstd:1", "zstd:19", "bitpack"};
  for (int codec = 0; codec < 7; ++codec)
    for (int filter = 0; filter < 2; ++filter) {
      const std::string coding = {static_cast<char>(codec), static_cast<char>(filter), 2};
      const std::string name = "codec" + std::to_string(codec) + (filter == 0 ? "" : "_shuffle");
      const std::string pipeline = std::string(filter == 0 ? "none," : "shuffle,") + codecs[codec];
      const OpenPipeline made = default_pipelines().open(pipeline, {});
      BlockCoder coder(default_pipelines().make_codec(Pipeline(pipeline).codec), smooth.size(), 2,
                       0);
      const EncodedBlock encoded = coder.encode({made.filters}, bytes_of(smooth));
      seed("codec_decode", name.c_str(),
           coding + number(static_cast<std::uint16_t>(smooth.size())) + text_of(encoded.bytes));
      seed("codec_decode", (name + "_short").c_str(),
           coding + number(std::uint16_t{790}) + text_of(encoded.bytes));
      const std::string room = number(std::uint16_t{100});
      seed("codec_round_trip", name.c_str(), coding + room + (codec % 2 == 0 ? smooth : noise));
    }
  seed("codec_round_trip", "one_byte", std::string("\2\1\3\0\0x", 6));
  seed("codec_round_trip", "zeros", std::string("\1\0\0\0\0", 5) + std::string(1000, '\0'));
}

void seed_numbers() {
  const auto level = [](std::uint64_t edges, std::int32_t number_of_level, std::uint64_t record,
                        std::uint8_t block, const std::vector<EdgeId>& borders) {
    std::string bytes = number(edges) + number(number_of_level) + number(record) + number(block);
    for (const EdgeId edge : borders) bytes += number(edge);
    return bytes;
  };
  seed("level_geometry", "closed", level(30, 5, 12, 20, {}));
  seed("level_geometry", "border", level(7, 3, 1, 12, {0, 3, 6}));
  seed("level_geometry", "deep", level(3, 20, 2040, 63, {1}));
  seed("level_geometry", "nearly_too_large", level(4294967294, 12, 511, 0, {4294967293}));
  seed("level_geometry", "one_block", level(4294967294, 1, 12, 63, {0}));
  seed("level_geometry", "too_large", level(4294967294, 20, ~std::uint64_t{0}, 30, {}));
  // The last ones: too large, too small, and no numbers at all.
  const char* const words[] = {"-1.5e+3",
                               "+0.1E-400",
                               "9223372036854775807",
                               "nan",
                               "-inf",
                               ".5",
                               "1e308",
                               "0e99999999999",
                               "0.1e400",
                               "1e99999999999999999999",
                               "-1e-99999999999999999999",
                               "+-1",
                               "++1",
                               "nan(xxxxxx)"};
  int count = 0;
  for (const char* word : words)
    seed("number_text", ("word" + std::to_string(count++)).c_str(), word);
}

void seed_slot_filters() {
  std::string bytes;
  for (int i = 0; i < 1000; ++i)
    bytes += number(1.0f + 0.001f * static_cast<float>(i % 17 + i / 17));
  const auto seed_of = [&](std::uint8_t filter, std::uint8_t type, std::uint8_t components,
                           std::uint8_t level, std::uint64_t shapes) {
    return number(filter) + number(type) + number(components) + number(level) +
           number(std::uint8_t{30}) + number(std::uint8_t{1}) + number(shapes) + bytes;
  };
  const char* const names[] = {"columns", "shuffle",      "columns_shuffle",
                               "lattice", "lattice_fine", "lattice_columns"};
  for (std::uint8_t filter = 0; filter < 6; ++filter) {
    const std::string name = names[filter];
    seed("slot_filters", name.c_str(), seed_of(filter, 0, 2, 2, 0));
    seed("slot_filters", (name + "_float64").c_str(),
         seed_of(filter, 1, 2, 3, 0x8000'0000'0000'0020));
    seed("slot_filters", (name + "_half_and_absent").c_str(),
         seed_of(filter, 0, 2, 1, 0x8c8c'8c8c'8c8c'8c8c));
    seed("slot_filters", (name + "_integers").c_str(),
         seed_of(filter, 3, 0, 4, 0xaaaa'aaaa'aaaa'aaaa));
  }
}

void seed_context_filters() {
  std::string smooth, extreme;
  for (int i = 0; i < 60; ++i)
    smooth += number(1.0f + 0.001f * static_cast<float>(i % 17 + i / 17));
  for (const float each : {std::numeric_limits<float>::quiet_NaN(), -0.0f, 1e38f,
                           std::numeric_limits<float>::infinity(), 1e-42f, -1.5f})
    extreme += number(each);
  const char* const names[] = {
      "hierarchy", "hierarchy_midpoint",  "hierarchy_step", "midpoint_step",
      "normals",   "normals_of_position", "hierarchy_along"};
  for (std::uint8_t filter = 0; filter < 7; ++filter) {
    const auto seed_of = [&](const std::string& name, std::uint8_t mesh, std::uint8_t type,
                             std::uint8_t level, const std::string& bytes) {
      seed("context_filters", (names[filter] + name).c_str(),
           number(filter) + number(mesh) + number(type) + number(level) + number(std::uint8_t{1}) +
               bytes);
    };
    seed_of("", 0, 0, 3, smooth);
    seed_of("_float64_border", 2, 1, 2, smooth);
    seed_of("_extreme", 1, 0, 2, extreme);
    seed_of("_depths", 3, 0, 3, smooth);
    if (filter < 4) seed_of("_other_records", 2, filter % 3 + 2, 0, smooth);
  }
}

void seed_presets() {
  const char* const names[] = {"fast", "default", "small"};
  for (std::uint8_t preset = 0; preset < 3; ++preset)
    for (std::uint8_t attribute = 0; attribute < 2; ++attribute) {
      const std::string name = std::string(names[preset]) + (attribute == 0 ? "" : "_normal");
      const auto damaged = [&](std::uint8_t mesh, std::uint8_t level, std::uint8_t way) {
        return number(preset) + number(attribute) + number(mesh) + number(level) +
               number(std::uint8_t{0}) + number(way);
      };
      seed("presets", name.c_str(), damaged(0, 3, 0));
      seed("presets", (name + "_changed").c_str(),
           damaged(2, 2, 0) + number(std::uint16_t{20}) + '\x40' + number(std::uint16_t{60}) +
               '\x01');
      seed("presets", (name + "_cut").c_str(), damaged(4, 3, 1) + number(std::uint16_t{40}));
      seed("presets", (name + "_other").c_str(), damaged(5, 1, 2) + std::string(50, '\x11'));
    }
}

void seed_predicted_recipes() {
  const std::string made(24, '\xff'), absent(24, '\0');
  const std::string encoded = number(BlockEntry{512, 100, BlockEncoding::kEncoded, 0, 5}),
                    wrong = number(BlockEntry{0, 0, BlockEncoding::kPredicted, 0, 5});
  const auto file = [](std::uint8_t mesh, std::uint8_t attribute, std::uint8_t level,
                       const std::string& entries, const char* recipe) {
    return number(mesh) + number(attribute) + number(level) + '\0' + entries + recipe;
  };
  seed("predicted_recipe", "position", file(0, 0, 3, made + absent, "loop/position/float32/4"));
  seed("predicted_recipe", "normal_float64_border",
       file(5, 1, 2, made + encoded, "midpoint/normal/float64/20"));
  seed("predicted_recipe", "normals_of_positions",
       file(0, 1, 3, made + wrong, "normals/position/4"));
  seed("predicted_recipe", "normals_of_border_positions",
       file(5, 1, 1, made + made, "normals/position/4"));
  seed("predicted_recipe", "unknown_rule", file(0, 1, 3, made + wrong, "angles/position/4"));
  seed("predicted_recipe", "limit", file(2, 0, 1, wrong + made, "loop/limit/float32/3"));
  seed("predicted_recipe", "finer_than_the_recipe",
       file(1, 0, 3, made + made, "loop/position/float32/2"));
  seed("predicted_recipe", "other_precision",
       file(1, 0, 3, made + made, "loop/position/float64/4"));
  seed("predicted_recipe", "unknown_scheme",
       file(1, 0, 0, made + made, "butterfly/position/float32/4"));
  seed("predicted_recipe", "no_recipe", file(1, 0, 0, made + wrong, "loop/position/float32"));
  seed("predicted_recipe", "many_levels",
       file(1, 1, 0, wrong + wrong, "loop/normal/float32/999999999999"));
}

void seed_bounds() {
  const auto file = [](const std::vector<float>& bounds, std::uint64_t key) {
    std::string bytes = "plaitbox" + number(std::uint32_t{1}) + number(std::uint32_t{0}) +
                        number(std::uint64_t{bounds.size() / 6}) + number(key);
    for (const float each : bounds) bytes += number(each);
    bytes += number(checksum_of(bytes_of(bytes)));
    return static_cast<char>(bounds.size() / 6) + bytes;  // the target takes the count first
  };
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const std::vector<float> two = {-1, 0, 0, 1, 2, 3, kInfinity, 0, 0, -kInfinity, 1, 1};
  seed("bounds_file", "no_face", file({}, 5));
  seed("bounds_file", "two_faces", file(two, 7));
  std::vector<float> nan = two;
  nan[4] = std::numeric_limits<float>::quiet_NaN();
  seed("bounds_file", "not_a_number", file(nan, 7));
  std::string cut = file(two, 7);
  cut.pop_back();
  seed("bounds_file", "cut", cut);
  std::string damaged = file(two, 7);
  damaged[40] = '\1';
  seed("bounds_file", "damaged", damaged);
  std::string other_count = file(two, 7);
  other_count.front() = '\3';
  seed("bounds_file", "of_another_mesh", other_count);
}

void seed_pipelines() {
  int count = 0;
  for (const char* const text :
       {"none", "zstd:-5", "shuffle+none,lz4", "x-delta:stride=3+shuffle,zstd:c=1,d=2",
        "predicted+hierarchy:loop:step=2e-06+shuffle,zstd:9", "predicted:normals/position/4,lz4",
        "shuffle,zstd:1;@1-3=lz4;@4=none;@6-=columns,bitpack", "lz4;@1=none;@2-3=none", "default",
        "position=small", "@1-3=fast", "normal@6-=lattice:3,x-codec:a=1@2", "lz4;", "shuffle+,lz4",
        "predicted+predicted,lz4", "lz4;@2=none;@1=none", "@3-1=lz4", "uv@1-3", "@1-3=lz4;@5=none"})
    seed("pipelines", ("text" + std::to_string(count++)).c_str(), text);
}

}  // namespace

int main(int argument_count, char** arguments) try {
  if (argument_count != 2) {
    std::fprintf(stderr, "usage: make_corpora DIRECTORY\n");
    return 2;
  }
  corpora = arguments[1];
  seed_meshes();
  seed_base_meshes();
  seed_base_records();
  seed_manifests();
  seed_descriptions();
  seed_block_tables();
  seed_codecs();
  seed_numbers();
  seed_slot_filters();
  seed_context_filters();
  seed_presets();
  seed_predicted_recipes();
  seed_pipelines();
  seed_bounds();
  return 0;
} catch (const std::exception& failure) {
  std::fprintf(stderr, "make_corpora: %s\n", failure.what());
  return 1;
}
