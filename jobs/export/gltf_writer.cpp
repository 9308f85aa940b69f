#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "export/format_writers.h"
#include "export/gltf_document.h"
#include "export/vertex_stream.h"
#include "plait/extend/vertex_numbering.h"
#include "plait/reader.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

static_assert(std::endian::native == std::endian::little,
              "numbers are written to the file without conversion");

constexpr double kLatticeSteps = 65535;
constexpr std::size_t kChunkHeaderBytes = 8, kGlbHeaderBytes = 12;

std::array<double, 3> vector_of(std::span<const std::byte> record, ComponentType type) {
  std::array<double, 3> point{};
  if (type == ComponentType::kFloat64) {
    std::memcpy(point.data(), record.data(), sizeof(point));
  } else {
    std::array<float, 3> narrow{};
    std::memcpy(narrow.data(), record.data(), sizeof(narrow));
    std::copy(narrow.begin(), narrow.end(), point.begin());
  }
  return point;
}

void check_finite(const ExportTask& task, const std::array<double, 3>& point) {
  for (const double coordinate : point)
    if (!(std::fabs(coordinate) <= std::numeric_limits<float>::max()))
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("export {}: a vertex with coordinate {}, but glTF files can have "
                              "finite float32 numbers only",
                              task.store.path().native(), coordinate));
}

void extend(GltfBounds& bounds, const std::array<double, 3>& point) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    bounds.low[axis] = std::min(bounds.low[axis], point[axis]);
    bounds.high[axis] = std::max(bounds.high[axis], point[axis]);
  }
}

GltfBounds no_bounds() {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  return {{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
}

/// The finest lattice whose steps are powers of two and that has all vertices in 16 bits. Its
/// points are multiples of the step, so two files with the same step have a common lattice.
GltfLattice lattice_of(const ExportTask& task) {
  GltfBounds bounds = no_bounds();
  const AttributeSchema& schema = task.schema(task.position);
  stream_vertices(
      task.store, std::span(&task.position, 1), task.patches, [&](auto records, std::size_t count) {
        const std::size_t bytes = schema.record_bytes();
        for (std::size_t at = 0; at < count; ++at) {
          const auto point = vector_of(records[0].subspan(at * bytes, bytes), schema.type);
          check_finite(task, point);
          extend(bounds, point);
        }
        task.progress(0);
      });
  double longest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    longest = std::max(longest, bounds.high[axis] - bounds.low[axis]);
  GltfLattice lattice;
  if (longest > 0) lattice.step = std::exp2(std::ceil(std::log2(longest / (kLatticeSteps - 1))));
  for (std::size_t axis = 0; axis < 3; ++axis)
    lattice.origin[axis] = std::round(bounds.low[axis] / lattice.step);
  return lattice;
}

class GltfWriter {
 public:
  GltfWriter(const ExportTask& task, const GltfDocument& document, const GltfLattice* lattice,
             OutputStream& output)
      : task_(task),
        document_(document),
        lattice_(lattice),
        output_(output),
        bounds_(document.group_count(), no_bounds()) {}

  void write() {
    write_indices();
    std::vector<std::string> names;
    for (const GltfColumn& column : document_.columns())
      names.push_back(task_.schema(column.attribute).name);
    const Reader reader(task_.store, {.attributes = names, .policy = EvictionPolicy::kLayoutOrder});
    for (const GltfColumn& column : document_.columns()) write_column(reader, column);
  }
  std::span<const GltfBounds> bounds() const { return bounds_; }

 private:
  template <class Index>
  void write_indices_as() {
    const std::int64_t size = std::int64_t{1} << task_.patches.refinements();
    for (std::uint64_t patch = 0; patch < document_.patches_of_group(); ++patch)
      for_each_triangle(task_.patches.refinements(), [&](const std::array<FacePoint, 3>& corners) {
        std::array<Index, 3> triangle{};
        for (std::size_t corner = 0; corner < 3; ++corner)
          triangle[corner] = static_cast<Index>(
              patch * document_.patch_vertices() +
              static_cast<std::uint64_t>(patch_vertex(size, corners[corner].i, corners[corner].j)));
        output_.write(std::as_bytes(std::span(triangle)));
      });
    const std::uint64_t bytes = document_.patches_of_group() * 3 * sizeof(Index)
                                << (2 * task_.patches.refinements());
    output_.write(std::string_view("\0\0\0", (4 - bytes % 4) % 4));
  }
  void write_indices() {
    if (document_.index_bytes() == 2)
      write_indices_as<std::uint16_t>();
    else
      write_indices_as<std::uint32_t>();
  }

  void write_column(const Reader& reader, const GltfColumn& column) {
    const AttributeSchema& schema = task_.schema(column.attribute);
    const std::size_t bytes = schema.record_bytes();
    std::vector<std::byte> records, numbers;
    for (std::uint64_t number = 0; number < document_.group_count(); ++number) {
      const std::span<const FaceId> faces = document_.group(number);
      const std::size_t count = faces.size() * document_.patch_vertices();
      records.resize(count * bytes);
      reader.copy_patches(schema.name, faces, task_.level, records);
      numbers.assign(count * column.stride, std::byte{0});
      for (std::size_t at = 0; at < count; ++at)
        convert(std::span(records).subspan(at * bytes, bytes), schema, column,
                std::span(numbers).subspan(at * column.stride, column.stride), bounds_[number]);
      output_.write(numbers);
      const std::uint64_t steps = document_.group_count() * document_.columns().size();
      task_.progress((task_.vertices() + task_.triangles()) * ++done_ / steps);
    }
  }

  void convert(std::span<const std::byte> record, const AttributeSchema& schema,
               const GltfColumn& column, std::span<std::byte> number, GltfBounds& bounds) const {
    const bool position = column.attribute == task_.position;
    switch (column.conversion) {
      case GltfConversion::kCopy:
        std::memcpy(number.data(), record.data(), record.size());
        if (position) bound(vector_of(record, schema.type), bounds);
        break;
      case GltfConversion::kToFloat: {
        const std::array<double, 3> wide = vector_of(record, schema.type);
        const std::array<float, 3> narrow = {
            static_cast<float>(wide[0]), static_cast<float>(wide[1]), static_cast<float>(wide[2])};
        std::memcpy(number.data(), narrow.data(), sizeof(narrow));
        bound({narrow[0], narrow[1], narrow[2]}, bounds);
        break;
      }
      case GltfConversion::kToLattice: {
        std::array<double, 3> place = vector_of(record, schema.type);
        std::array<std::uint16_t, 3> whole{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          place[axis] = std::round(place[axis] / lattice_->step) - lattice_->origin[axis];
          whole[axis] = static_cast<std::uint16_t>(place[axis]);
        }
        std::memcpy(number.data(), whole.data(), sizeof(whole));
        bound(place, bounds);
        break;
      }
      case GltfConversion::kToBytes: {
        const std::array<double, 3> normal = vector_of(record, schema.type);
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const double component = std::isnan(normal[axis]) ? 0 : normal[axis];
          number[axis] = static_cast<std::byte>(
              static_cast<std::int8_t>(std::round(std::clamp(component, -1.0, 1.0) * 127)));
        }
        break;
      }
      case GltfConversion::kTexture: {
        std::array<float, 2> at{};
        std::memcpy(at.data(), record.data(), sizeof(at));
        at[1] = 1 - at[1];
        std::memcpy(number.data(), at.data(), sizeof(at));
        break;
      }
    }
  }

  void bound(const std::array<double, 3>& point, GltfBounds& bounds) const {
    check_finite(task_, point);
    extend(bounds, point);
  }

  const ExportTask& task_;
  const GltfDocument& document_;
  const GltfLattice* lattice_;
  OutputStream& output_;
  std::vector<GltfBounds> bounds_;
  std::uint64_t done_ = 0;
};

void append_word(std::string& bytes, std::uint64_t word) {
  const auto narrow = static_cast<std::uint32_t>(word);
  bytes.append(reinterpret_cast<const char*>(&narrow), sizeof(narrow));
}

/// One file: a header, the text, and the numbers. The text has the bounds of the groups, which are
/// known when all numbers are written, so its place is kept.
std::uint64_t write_glb(GltfDocument& document, File& file, const ExportTask& task,
                        const GltfLattice* lattice) {
  const std::size_t text_bytes = (document.most_text_bytes({}) + 3) / 4 * 4;
  const std::size_t before = kGlbHeaderBytes + kChunkHeaderBytes + text_bytes;
  OutputStream output(file, StreamCompression::kNone);
  output.write(std::string(before + kChunkHeaderBytes, ' '));
  GltfWriter writer(task, document, lattice, output);
  writer.write();
  output.close();
  std::string head = "glTF";
  append_word(head, 2);
  append_word(head, output.file_bytes());
  append_word(head, text_bytes);
  head += "JSON" + document.text(writer.bounds(), {});
  head.resize(before, ' ');
  append_word(head, document.total_bytes());
  head += std::string_view("BIN\0", 4);
  file.write_at(0, std::as_bytes(std::span(head)));
  return output.file_bytes();
}

/// A name of a file in the text of the other one: a URI, so other characters are percent-encoded.
std::string uri_of(std::string_view name) {
  std::string uri;
  for (const char c : name) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       c == '-' || c == '_' || c == '.' || c == '~';
    uri += plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return uri;
}

}  // namespace

GltfOutcome write_gltf_level(const ExportTask& task, OutputFiles& files) {
  GltfLattice lattice;
  const GltfLattice* used = task.request.quantize ? &lattice : nullptr;
  GltfDocument document(task, used);  // refuses what is too large before anything is read
  if (used != nullptr) lattice = lattice_of(task);
  GltfOutcome outcome{document.vertices(), 0, used != nullptr ? lattice.step / 2 : 0};
  if (task.format == MeshFormat::kGlb) {
    outcome.file_bytes = write_glb(document, files.main(), task, used);
    return outcome;
  }
  OutputStream output(files.add(".bin"), StreamCompression::kNone);
  GltfWriter writer(task, document, used, output);
  writer.write();
  output.close();
  OutputStream text(files.main(), StreamCompression::kNone);
  text.write(document.text(writer.bounds(), uri_of(files.name_of(".bin"))));
  text.close();
  outcome.file_bytes = output.file_bytes() + text.file_bytes();
  return outcome;
}

PLAIT_END_NAMESPACE
