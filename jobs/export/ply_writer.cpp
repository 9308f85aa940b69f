#include <fmt/format.h>

#include <array>
#include <bit>
#include <cstring>
#include <string>
#include <vector>

#include "export/format_writers.h"
#include "export/vertex_stream.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

static_assert(std::endian::native == std::endian::little,
              "records are written to the file without conversion");

/// The original type names of PLY, which every reader knows. There is none for 64-bit integers.
const char* ply_type(ComponentType type) {
  switch (type) {
    case ComponentType::kFloat32:
      return "float";
    case ComponentType::kFloat64:
      return "double";
    case ComponentType::kInt8:
      return "char";
    case ComponentType::kInt16:
      return "short";
    case ComponentType::kInt32:
      return "int";
    case ComponentType::kUint8:
      return "uchar";
    case ComponentType::kUint16:
      return "ushort";
    case ComponentType::kUint32:
      return "uint";
    default:
      return nullptr;
  }
}

std::string property_name(const AttributeSchema& schema, std::uint32_t component) {
  static constexpr std::array<const char*, 3> kPosition = {"x", "y", "z"};
  static constexpr std::array<const char*, 3> kNormal = {"nx", "ny", "nz"};
  static constexpr std::array<const char*, 4> kColor = {"red", "green", "blue", "alpha"};
  static constexpr std::array<const char*, 2> kTexture = {"s", "t"};
  if (schema.components == 3 && schema.name == "position") return kPosition[component];
  if (schema.components == 3 && schema.name == "normal") return kNormal[component];
  if ((schema.components == 3 || schema.components == 4) && schema.name == "color")
    return kColor[component];
  if (schema.components == 2 && schema.name == "texture") return kTexture[component];
  return schema.components == 1 ? schema.name : fmt::format("{}_{}", schema.name, component);
}

std::string ply_header(const ExportTask& task, std::span<const AttributeId> attributes,
                       std::span<const FaceColumn> columns, const char* index_type) {
  std::string text = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment plait: level {}\nelement vertex {}\n",
      task.level, task.vertices());
  for (const AttributeId id : attributes) {
    const AttributeSchema& schema = task.schema(id);
    for (std::uint32_t component = 0; component < schema.components; ++component)
      text +=
          fmt::format("property {} {}\n", ply_type(schema.type), property_name(schema, component));
  }
  text += fmt::format("element face {}\nproperty list uchar {} vertex_indices\n", task.triangles(),
                      index_type);
  for (const FaceColumn& column : columns)
    text += fmt::format("property {} {}\n", ply_type(column.schema.type), column.schema.name);
  return text + "end_header\n";
}

}  // namespace

void write_ply_level(const ExportTask& task, OutputStream& output) {
  std::vector<AttributeId> attributes = {task.position};
  attributes.insert(attributes.end(), task.extras.begin(), task.extras.end());
  const std::vector<FaceColumn> columns = face_columns(task);
  output.write(
      ply_header(task, attributes, columns, fits_31_bits(task.vertices()) ? "int" : "uint"));

  std::vector<std::byte> rows;
  std::uint64_t done = 0;
  stream_vertices(task.store, attributes, task.patches, [&](auto records, std::size_t count) {
    task.progress(done += count);
    if (records.size() == 1) return output.write(records[0]);
    rows.clear();
    for (std::size_t vertex = 0; vertex < count; ++vertex)
      for (const std::span<const std::byte> column : records) {
        const std::size_t bytes = column.size() / count;
        const auto record = column.subspan(vertex * bytes, bytes);
        rows.insert(rows.end(), record.begin(), record.end());
      }
    output.write(rows);
  });

  std::size_t face_bytes = 13;
  for (const FaceColumn& column : columns) face_bytes += column.schema.record_bytes();
  std::vector<std::byte> row(face_bytes * most_triangles_of_row(task.patches));
  std::byte* next = row.data();
  for_each_numbered_triangle(
      task.patches,
      [&](FaceId of_face, std::uint64_t a, std::uint64_t b, std::uint64_t c) {
        *next++ = std::byte{3};
        for (const std::uint64_t corner : {a, b, c}) {
          const auto number = static_cast<std::uint32_t>(corner);
          std::memcpy(next, &number, sizeof(number));
          next += sizeof(number);
        }
        for (const FaceColumn& column : columns) {
          const std::size_t bytes = column.schema.record_bytes();
          std::memcpy(next, column.numbers.data() + of_face * bytes, bytes);
          next += bytes;
        }
      },
      [&](std::uint64_t triangles) {
        output.write(std::span(row.data(), next));
        next = row.data();
        task.progress(done + triangles);
      });
}

PLAIT_END_NAMESPACE
