// VTK's XML files of polygons. The text names the arrays and where they begin; their bytes follow
// it as they are ("raw appended data"), each array after its length in 64 bits.
// Source: Kitware, "VTK file formats", 2010, section "XML file formats".

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <string>
#include <vector>

#include "export/format_writers.h"
#include "export/vertex_stream.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

static_assert(std::endian::native == std::endian::little,
              "numbers are written to the file without conversion");

constexpr std::uint64_t kTrianglesOfPiece = 4 << 20;
constexpr std::uint64_t kMostPieces = 64;  // each has open files until all are complete

/// "Float32", "UInt8".
std::string vtk_type(ComponentType type) {
  std::string name(to_string(type));
  name.front() = static_cast<char>(std::toupper(name.front()));
  if (name.starts_with("Ui")) name[1] = 'I';
  return name;
}

constexpr std::string_view kBeginning = "<?xml version=\"1.0\"?>\n";

/// How a piece begins. A later export with fewer pieces knows by it which files it may remove.
std::string begin_piece(std::uint64_t piece) {
  return fmt::format("{}<!-- piece {} of plait export -->\n", kBeginning, piece);
}

/// What follows the beginning of a file.
std::string begin_data(std::string_view kind) {
  return fmt::format(
      "<VTKFile type=\"{0}\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n<{0}",
      kind);
}

/// The arrays of a piece in the order of their bytes.
class ArrayList {
 public:
  /// `element` is DataArray, or PDataArray in the file that names the pieces.
  explicit ArrayList(std::string_view element) : element_(element) {}
  std::string add(const AttributeSchema& schema, std::uint64_t bytes) {
    std::string text = fmt::format("<{} type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\"",
                                   element_, vtk_type(schema.type), schema.name, schema.components);
    if (element_ == "DataArray") text += fmt::format(" format=\"appended\" offset=\"{}\"", offset_);
    offset_ += sizeof(std::uint64_t) + bytes;
    return text + "/>\n";
  }

 private:
  std::string_view element_;
  std::uint64_t offset_ = 0;
};

/// Attributes of points and of triangles, and the points: what a piece and the file that names the
/// pieces say in the same way. `prefix` is "P" in that file.
std::string arrays_of(const ExportTask& task, std::string_view prefix, ArrayList& arrays) {
  const bool normals = std::ranges::any_of(task.extras, [&](AttributeId id) {
    return task.schema(id).name == "normal" && task.schema(id).components == 3;
  });
  std::string text = fmt::format("<{}PointData{}>\n", prefix, normals ? " Normals=\"normal\"" : "");
  for (const AttributeId id : task.extras)
    text += arrays.add(task.schema(id), task.vertices() * task.schema(id).record_bytes());
  text += fmt::format("</{0}PointData>\n<{0}CellData>\n", prefix);
  for (const FaceColumn& column : face_columns(task))
    text += arrays.add(column.schema, task.triangles() * column.schema.record_bytes());
  AttributeSchema points = task.schema(task.position);
  points.name = "Points";
  text += fmt::format("</{0}CellData>\n<{0}Points>\n", prefix);
  text += arrays.add(points, task.vertices() * points.record_bytes());
  return text + fmt::format("</{}Points>\n", prefix);
}

/// Bytes of an index: of 32 bits where all indices of the piece fit.
std::size_t index_bytes(const ExportTask& task) {
  return fits_31_bits(3 * task.triangles()) && fits_31_bits(task.vertices()) ? 4 : 8;
}

std::string header(const ExportTask& task, std::string_view beginning) {
  const std::size_t bytes = index_bytes(task);
  const ComponentType type = bytes == 4 ? ComponentType::kInt32 : ComponentType::kInt64;
  ArrayList arrays("DataArray");
  std::string text(beginning);
  text += begin_data("PolyData");
  text += fmt::format(
      ">\n<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"0\" NumberOfLines=\"0\" "
      "NumberOfStrips=\"0\" NumberOfPolys=\"{}\">\n",
      task.vertices(), task.triangles());
  text += arrays_of(task, "", arrays);
  text += "<Polys>\n";
  text += arrays.add({"connectivity", type, 1}, 3 * task.triangles() * bytes);
  text += arrays.add({"offsets", type, 1}, task.triangles() * bytes);
  return text + "</Polys>\n</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_";
}

class PieceWriter {
 public:
  PieceWriter(const ExportTask& task, OutputStream& output, std::uint64_t done)
      : task_(task), output_(output), done_(done) {}

  /// `beginning` is kBeginning or begin_piece().
  void write(std::string_view beginning) {
    output_.write(header(task_, beginning));
    for (const AttributeId id : task_.extras) write_attribute(id, false);
    for (const FaceColumn& column : face_columns(task_)) write_column(column);
    write_attribute(task_.position, true);
    if (index_bytes(task_) == 4)
      write_indices<std::int32_t>();
    else
      write_indices<std::int64_t>();
    output_.write("\n</AppendedData>\n</VTKFile>\n");
  }

 private:
  void begin_array(std::uint64_t bytes) { output_.write(std::as_bytes(std::span(&bytes, 1))); }

  void write_attribute(AttributeId id, bool counts) {
    begin_array(task_.vertices() * task_.schema(id).record_bytes());
    stream_vertices(task_.store, std::span(&id, 1), task_.patches,
                    [&](auto records, std::size_t count) {
                      output_.write(records[0]);
                      if (counts) done_ += count;
                      task_.progress(done_);
                    });
  }

  void write_column(const FaceColumn& column) {
    const std::size_t bytes = column.schema.record_bytes();
    begin_array(task_.triangles() * bytes);
    for (const FaceId face : task_.patches.faces())
      for (std::uint64_t left = task_.patches.drawn(face).triangle_count(); left > 0; --left)
        output_.write(column.numbers.subspan(face * bytes, bytes));
  }

  template <class Index>
  void write_indices() {
    begin_array(3 * task_.triangles() * sizeof(Index));
    const std::uint64_t before = done_;
    std::vector<Index> row(3 * most_triangles_of_row(task_.patches));
    Index* next = row.data();
    for_each_numbered_triangle(
        task_.patches,
        [&](FaceId, std::uint64_t a, std::uint64_t b, std::uint64_t c) {
          *next++ = static_cast<Index>(a);
          *next++ = static_cast<Index>(b);
          *next++ = static_cast<Index>(c);
        },
        [&](std::uint64_t triangles) {
          output_.write(std::as_bytes(std::span(row.data(), next)));
          next = row.data();
          task_.progress(done_ = before + triangles);
        });
    begin_array(task_.triangles() * sizeof(Index));
    for (std::uint64_t triangle = 1; triangle <= task_.triangles(); ++triangle) {
      const auto after = static_cast<Index>(3 * triangle);
      output_.write(std::as_bytes(std::span(&after, 1)));
    }
  }

  const ExportTask& task_;
  OutputStream& output_;
  std::uint64_t done_;
};

/// A name of a file in an attribute of XML.
std::string xml_text(std::string_view name) {
  std::string text;
  for (const char c : name)
    text += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '"' ? "&quot;" : std::string(1, c);
  return text;
}

}  // namespace

void write_vtp_level(const ExportTask& task, OutputStream& output) {
  PieceWriter(task, output, 0).write(kBeginning);
}

std::uint64_t write_pvtp_level(const ExportTask& task, OutputFiles& files) {
  const std::uint64_t wanted = task.request.pieces > 0
                                   ? task.request.pieces
                                   : (task.triangles() - 1) / kTrianglesOfPiece + 1;
  const std::uint64_t pieces =
      std::min<std::uint64_t>({wanted, kMostPieces, task.patches.faces().size()});
  ArrayList arrays("PDataArray");
  std::string text(kBeginning);
  text += begin_data("PPolyData") + " GhostLevel=\"0\">\n";
  text += arrays_of(task, "P", arrays);
  std::uint64_t bytes = 0, done = 0;
  const auto ending_of = [](std::uint64_t piece) { return fmt::format("_{}.vtp", piece); };
  for (std::uint64_t piece = 0; piece < pieces; ++piece) {
    const std::string ending = ending_of(piece);
    const PatchSelection part =
        task.patches.part(face_stretch(task.patches.faces(), piece, pieces));
    ExportTask of_piece{task.store,  task.request, task.format,   task.level, task.position,
                        task.extras, part,         task.progress, task.warn};
    OutputStream output(files.add(ending), StreamCompression::kNone);
    PieceWriter(of_piece, output, done).write(begin_piece(piece));
    output.close();
    bytes += output.file_bytes();
    done += part.vertex_count() + part.triangle_count();
    text += fmt::format("<Piece Source=\"{}\"/>\n", xml_text(files.name_of(ending)));
  }
  for (std::uint64_t piece = pieces; piece < kMostPieces; ++piece)
    files.remove_older(ending_of(piece), begin_piece(piece));
  OutputStream output(files.main(), StreamCompression::kNone);
  output.write(text + "</PPolyData>\n</VTKFile>\n");
  output.close();
  return bytes + output.file_bytes();
}

PLAIT_END_NAMESPACE
