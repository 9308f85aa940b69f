#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "export/format_writers.h"
#include "export/gltf_document.h"
#include "export/gltf_survey.h"
#include "export/numbered_triangles.h"
#include "export/vertex_stream.h"
#include "plait/extend/vertex_numbering.h"
#include "plait/reader.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

static_assert(std::endian::native == std::endian::little,
              "numbers are written to the file without conversion");

constexpr std::size_t kChunkHeaderBytes = 8, kGlbHeaderBytes = 12;

class GltfWriter {
 public:
  GltfWriter(const ExportTask& task, const GltfDocument& document, const GltfPlacement& placement,
             OutputStream& output)
      : task_(task),
        document_(document),
        placement_(placement),
        output_(output),
        bounds_(document.group_count(), no_bounds()) {}

  void write() {
    write_indices();
    if (document_.has_equal_patches()) {
      write_groups();
      return;
    }
    for (const GltfColumn& column : document_.columns())
      stream_vertices(task_.store, std::span(&column.attribute, 1), task_.patches,
                      [&](auto records, std::size_t count) {
                        write_numbers(column, records[0], count, 0);
                        report(document_.vertices() * document_.columns().size(), count);
                      });
  }
  std::span<const GltfBounds> bounds() const { return bounds_; }
  const Moved& moved() const { return moved_; }
  std::uint64_t side_normals() const { return side_normals_; }

 private:
  template <class Index>
  void write_indices_as() {
    std::uint64_t written = 0;
    const auto write = [&](std::array<Index, 3> triangle) {
      output_.write(std::as_bytes(std::span(triangle)));
      written += sizeof triangle;
    };
    if (!document_.has_equal_patches()) {
      for_each_numbered_triangle(
          task_.patches,
          [&](FaceId, std::uint64_t a, std::uint64_t b, std::uint64_t c) {
            write({static_cast<Index>(a), static_cast<Index>(b), static_cast<Index>(c)});
          },
          [&](std::uint64_t) { task_.progress(0); });
    } else {
      const std::int64_t size = std::int64_t{1} << task_.patches.refinements();
      for (std::uint64_t patch = 0; patch < document_.patches_of_group(); ++patch)
        for_each_triangle(
            task_.patches.refinements(), [&](const std::array<FacePoint, 3>& corners) {
              std::array<Index, 3> triangle{};
              for (std::size_t corner = 0; corner < 3; ++corner)
                triangle[corner] =
                    static_cast<Index>(patch * document_.patch_vertices() +
                                       static_cast<std::uint64_t>(patch_vertex(
                                           size, corners[corner].i, corners[corner].j)));
              write(triangle);
            });
    }
    output_.write(std::string_view("\0\0\0", (4 - written % 4) % 4));
  }
  void write_indices() {
    if (document_.index_bytes() == 2)
      write_indices_as<std::uint16_t>();
    else
      write_indices_as<std::uint32_t>();
  }

  void write_groups() {
    std::vector<std::string> names;
    for (const GltfColumn& column : document_.columns())
      names.push_back(task_.schema(column.attribute).name);
    const Reader reader(task_.store, {.attributes = names, .policy = EvictionPolicy::kLayoutOrder});
    std::vector<std::byte> records;
    for (const GltfColumn& column : document_.columns())
      for (std::uint64_t number = 0; number < document_.group_count(); ++number) {
        const AttributeSchema& schema = task_.schema(column.attribute);
        const std::span<const FaceId> faces = document_.group(number);
        const std::size_t count = faces.size() * document_.patch_vertices();
        records.resize(count * schema.record_bytes());
        reader.copy_patches(schema.name, faces, task_.level, records);
        if (task_.creases != nullptr && column.semantic == "NORMAL")
          put_side_normals(schema.type, faces, records);
        write_numbers(column, records, count, number);
        report(document_.group_count() * document_.columns().size(), 1);
      }
  }
  /// Replaces those at creases by those of the side.
  void put_side_normals(ComponentType type, std::span<const FaceId> faces,
                        std::span<std::byte> records) {
    const std::size_t bytes = records.size() / faces.size();
    for (std::size_t at = 0; at < faces.size(); ++at) {
      if (!task_.creases->points().has_any(faces[at])) continue;
      const std::span<std::byte> patch = records.subspan(at * bytes, bytes);
      if (!positions_) positions_.emplace(task_.store, task_.level);
      positions_->read(faces[at]);
      const auto position = [&](std::int64_t i, std::int64_t j) { return positions_->at(i, j); };
      task_.creases->for_each(
          faces[at], position, [&](std::int64_t i, std::int64_t j, const Vector3<float>& normal) {
            if (!(dot(normal, normal) > 0)) return;
            const auto vertex =
                static_cast<std::size_t>(patch_vertex(task_.creases->points().size(), i, j));
            if (type == ComponentType::kFloat64)
              put(patch, vertex, Vector3<double>{normal.x, normal.y, normal.z});
            else
              put(patch, vertex, normal);
            ++side_normals_;
          });
    }
  }
  template <class Record>
  static void put(std::span<std::byte> records, std::size_t vertex, const Record& record) {
    std::memcpy(records.data() + vertex * sizeof record, &record, sizeof record);
  }
  /// `group`: that of the vertices.
  void write_numbers(const GltfColumn& column, std::span<const std::byte> records,
                     std::size_t count, std::uint64_t group) {
    const AttributeSchema& schema = task_.schema(column.attribute);
    const std::size_t bytes = schema.record_bytes();
    numbers_.assign(count * column.stride, std::byte{0});
    for (std::size_t at = 0; at < count; ++at) {
      double error = 0;
      const GltfVector point =
          convert_record(records.subspan(at * bytes, bytes), schema.type, column, placement_,
                         std::span(numbers_).subspan(at * column.stride, column.stride), error);
      if (error > 0) moved_ = {std::max(moved_.most, error), moved_.count + 1};
      if (column.attribute == task_.position) extend(bounds_[group], point);
    }
    output_.write(numbers_);
  }
  void report(std::uint64_t steps, std::uint64_t more) {
    done_ += more;
    const double share = static_cast<double>(done_) / static_cast<double>(steps);
    task_.progress(static_cast<std::uint64_t>(
        static_cast<double>(task_.vertices() + task_.triangles()) * share));
  }

  const ExportTask& task_;
  const GltfDocument& document_;
  const GltfPlacement& placement_;
  OutputStream& output_;
  std::vector<GltfBounds> bounds_;
  std::vector<std::byte> numbers_;
  std::uint64_t done_ = 0;
  Moved moved_;
  std::optional<PatchPositions> positions_;  ///< for normals at creases
  std::uint64_t side_normals_ = 0;
};

void append_word(std::string& bytes, std::uint64_t word) {
  const auto narrow = static_cast<std::uint32_t>(word);
  bytes.append(reinterpret_cast<const char*>(&narrow), sizeof(narrow));
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

/// What the file has in another way than the store, or not at all.
void warn_of(const ExportTask& task, const GltfSurvey& found) {
  const auto warn = [&](std::uint64_t count, std::string_view what) {
    if (count > 0)
      task.warn(fmt::format("export {}: {} of {} vertices have {}", task.store.path().native(),
                            count, task.vertices(), what));
  };
  warn(found.normals_without_direction,
       "a normal without direction, and glTF files have normals of length 1 only, so the file has "
       "no normals; .ply and .vtp files keep them");
  if (found.normals_without_direction == 0)
    warn(found.normals_scaled,
         "a normal of another length than 1, which the file has with length 1; .ply and .vtp files "
         "keep it");
  warn(found.colors_clamped,
       "a colour outside 0 to 1, which the file has clamped; .ply and .vtp files keep it");
}

/// Viewers draw NORMAL, COLOR_0 and TEXCOORD_0, and nothing that an application names itself.
void warn_of_own_names(const ExportTask& task, std::span<const GltfColumn> columns) {
  const std::pair<std::string_view, std::string_view> drawn[] = {
      {"normal", "3 of float32 or float64"},
      {"color", "3 or 4 of uint8, uint16, float32 or float64"},
      {"texture", "2 of float32 or float64"}};
  for (const GltfColumn& column : columns) {
    const AttributeSchema& schema = task.schema(column.attribute);
    for (const auto& [name, records] : drawn)
      if (schema.name == name && column.semantic.starts_with('_'))
        task.warn(
            fmt::format("export {}: '{}' has records of {} of {}, so the file has it as {}, "
                        "which viewers do not draw; expected {}",
                        task.store.path().native(), name, schema.components, to_string(schema.type),
                        column.semantic, records));
  }
}

/// Three numbers may be a direction, which would have to be turned with the surface, or may not.
void warn_of_unturned(const ExportTask& task, std::span<const GltfColumn> columns) {
  for (const GltfColumn& column : columns) {
    const AttributeSchema& schema = task.schema(column.attribute);
    const bool is_float =
        schema.type == ComponentType::kFloat32 || schema.type == ComponentType::kFloat64;
    if (schema.components != 3 || !is_float || !column.semantic.starts_with('_')) continue;
    task.warn(
        fmt::format("export {}: up z turns positions and normals only: {} has the three "
                    "numbers of '{}' as the store has them",
                    task.store.path().native(), column.semantic, schema.name));
  }
}

/// One file: a header, the text, and the numbers. The text has the bounds of the groups, which are
/// known when all numbers are written, so its place is kept.
void write_glb(const GltfDocument& document, const GltfPlacement& placement, const ExportTask& task,
               File& file, GltfOutcome& outcome) {
  const std::size_t text_bytes = (document.most_text_bytes({}) + 3) / 4 * 4;
  const std::size_t before = kGlbHeaderBytes + kChunkHeaderBytes + text_bytes;
  OutputStream output(file, StreamCompression::kNone);
  output.write(std::string(before + kChunkHeaderBytes, ' '));
  GltfWriter writer(task, document, placement, output);
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
  outcome.file_bytes = output.file_bytes();
  outcome.moved = writer.moved();
  outcome.side_normals = writer.side_normals();
}

/// A text, and the numbers in a file beside it.
void write_two_files(const GltfDocument& document, const GltfPlacement& placement,
                     const ExportTask& task, OutputFiles& files, GltfOutcome& outcome) {
  OutputStream output(files.add(".bin"), StreamCompression::kNone);
  GltfWriter writer(task, document, placement, output);
  writer.write();
  output.close();
  OutputStream text(files.main(), StreamCompression::kNone);
  text.write(document.text(writer.bounds(), uri_of(files.name_of(".bin"))));
  text.close();
  outcome.file_bytes = output.file_bytes() + text.file_bytes();
  outcome.moved = writer.moved();
  outcome.side_normals = writer.side_normals();
}

}  // namespace

GltfOutcome write_gltf_level(const ExportTask& task, OutputFiles& files) {
  GltfPlacement placement;
  placement.z_up = task.request.up == "z";
  placement.lattice = task.request.quantize;
  placement.moves = placement.lattice || task.schema(task.position).type == ComponentType::kFloat64;
  GltfDocument document(task, placement,
                        true);  // refuses what is too large before anything is read
  const GltfSurvey found = survey(task, document.columns(), placement);
  warn_of(task, found);
  warn_of_own_names(task, document.columns());
  if (placement.z_up) warn_of_unturned(task, document.columns());
  GltfOutcome outcome;
  outcome.without_normals = found.normals_without_direction > 0;
  if (outcome.without_normals) document = GltfDocument(task, placement, false);
  outcome.vertices = document.vertices();
  if (task.format == MeshFormat::kGlb)
    write_glb(document, placement, task, files.main(), outcome);
  else
    write_two_files(document, placement, task, files, outcome);
  return outcome;
}

PLAIT_END_NAMESPACE
