#include "export/mesh_export.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "argument_text.h"
#include "export/format_writers.h"

namespace plait {
namespace {

constexpr std::uint64_t kMaxCounted = std::numeric_limits<std::uint32_t>::max();

bool has_level(const Store& store, AttributeId attribute, int level) {
  return store.attributes()[attribute].finest_level >= level;
}

void check_level(const Store& store, AttributeId position, int level) {
  const int finest = store.attributes()[position].finest_level;
  if (level < store.base_level() || level > finest)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("export {}: level {}, expected {} to {}", store.path().native(), level,
                            store.base_level(), finest));
}

std::vector<AttributeId> chosen_attributes(const Store& store, AttributeId position,
                                           const ExportOptions& options) {
  std::vector<AttributeId> chosen;
  for (const std::string& name : options.attributes) {
    const AttributeId id = store.attribute(name);
    if (id == position) continue;
    const AttributeSchema& schema = store.attributes()[id].schema;
    if (!has_level(store, id, options.level))
      throw Error(
          ErrorCode::kInvalidArgument,
          fmt::format("export {}: attribute '{}' ends at level {}, expected level {} or more",
                      store.path().native(), name, store.attributes()[id].finest_level,
                      options.level));
    if (options.format.mesh == MeshFormat::kPly) check_ply_attribute(schema);
    const bool normal = schema == schema_of<Vector3<float>>("normal");
    if (options.format.mesh == MeshFormat::kStl ||
        (options.format.mesh == MeshFormat::kObj && !normal))
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("export {}: attribute '{}' cannot be written to {} files",
                              store.path().native(), name,
                              options.format.mesh == MeshFormat::kStl ? "STL" : "OBJ"));
    for (const AttributeId other : chosen)
      if (other == id)
        throw Error(ErrorCode::kInvalidArgument,
                    fmt::format("export: attribute '{}' was given twice", name));
    chosen.push_back(id);
  }
  return chosen;
}

void check_face_attributes(const Store& store, const ExportOptions& options) {
  for (std::size_t at = 0; at < options.face_attributes.size(); ++at) {
    const std::string& name = options.face_attributes[at];
    std::as_const(store).face_bytes(name);  // refuses unknown names
    if (options.format.mesh != MeshFormat::kPly)
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("export {}: face attribute '{}' can be written to PLY files only",
                              store.path().native(), name));
    if (std::ranges::find(options.face_attributes, name) !=
        options.face_attributes.begin() + static_cast<std::ptrdiff_t>(at))
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("export: face attribute '{}' was given twice", name));
  }
}

void check_counts(const Store& store, const ExportResult& counts, MeshFormat format) {
  const bool ply = format == MeshFormat::kPly;
  const std::uint64_t count = ply ? counts.vertices : counts.triangles;
  if (format != MeshFormat::kObj && count > kMaxCounted)
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format(
            "export {}: {} {}, but {} files can have at most {}; try a coarser level or OBJ",
            store.path().native(), count, ply ? "vertices" : "triangles", ply ? "PLY" : "STL",
            kMaxCounted));
}

void check_position(const Store& store, AttributeId position) {
  const AttributeSchema& schema = store.attributes()[position].schema;
  if (schema.components != 3 ||
      (schema.type != ComponentType::kFloat32 && schema.type != ComponentType::kFloat64))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("export {}: attribute 'position' holds {} x {}, expected float32 x 3 "
                            "or float64 x 3",
                            store.path().native(), to_string(schema.type), schema.components));
}

}  // namespace

ExportFormat export_format(const std::filesystem::path& path) {
  ExportFormat format;
  const std::string last = lower_extension(path);
  if (last == ".gz") format.compression = StreamCompression::kGzip;
  if (last == ".zst") format.compression = StreamCompression::kZstd;
  const std::string extension =
      format.compression == StreamCompression::kNone ? last : lower_extension(path.stem());
  if (extension == ".ply") return format;
  if (extension == ".obj")
    format.mesh = MeshFormat::kObj;
  else if (extension == ".stl")
    format.mesh = MeshFormat::kStl;
  else
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("export to {}: expected a name that ends in .ply, .obj or .stl, and "
                            "then .gz, .zst or nothing",
                            path.native()));
  return format;
}

ExportResult export_mesh(Store& store, File& file, const ExportOptions& options) {
  const AttributeId position = store.attribute("position");
  check_position(store, position);
  check_level(store, position, options.level);
  const std::vector<AttributeId> extras = chosen_attributes(store, position, options);
  check_face_attributes(store, options);
  const int refinements = relative_to_base(options.level, store.base_level()).refinements;
  const VertexNumbering numbering(store.base().topology(), refinements);
  ExportResult result{numbering.vertex_count(), triangle_count(store.base(), refinements), 0};
  check_counts(store, result, options.format.mesh);

  const bool facets = options.format.mesh == MeshFormat::kStl;
  const std::uint64_t total = result.triangles + (facets ? 0 : result.vertices);
  OutputStream output(file, options.format.compression);
  const ExportTask task{store,
                        position,
                        extras,
                        options.level,
                        refinements,
                        numbering,
                        output,
                        [&](std::uint64_t done) {
                          if (options.progress && !options.progress({"export", done, total}))
                            throw Error(ErrorCode::kCancelled, "export: cancelled");
                        },
                        options.face_attributes};
  switch (options.format.mesh) {
    case MeshFormat::kPly:
      write_ply_level(task);
      break;
    case MeshFormat::kObj:
      write_obj_level(task);
      break;
    case MeshFormat::kStl:
      write_stl_level(task);
      break;
  }
  output.close();
  result.file_bytes = output.file_bytes();
  return result;
}

}  // namespace plait
