#include "export/export_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <utility>

#include "base/text.h"
#include "export/format_writers.h"
#include "export/output_files.h"
#include "plait/extend/store_access.h"
#include "plait/notes.h"
#include "plait/reader.h"
#include "store/base_positions.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::uint64_t kMaxCounted = std::numeric_limits<std::uint32_t>::max();

void check_level(const Store& store, AttributeId position, int level) {
  const int finest = store.attributes()[position].finest_level;
  if (level < store.base_level() || level > finest)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("export {}: level {}, expected {} to {}", store.path().native(), level,
                            store.base_level(), finest));
}

std::vector<AttributeId> chosen_attributes(const Store& store, AttributeId position, int level,
                                           MeshFormat format, const ExportRequest& request) {
  std::vector<AttributeId> chosen;
  for (const std::string& name : request.attributes) {
    const AttributeId id = store.attribute(name);
    if (id == position) continue;
    const AttributeSchema& schema = store.attributes()[id].schema;
    if (store.attributes()[id].finest_level < level)
      throw Error(
          ErrorCode::kInvalidArgument,
          fmt::format("export {}: attribute '{}' ends at level {}, expected level {} or more",
                      store.path().native(), name, store.attributes()[id].finest_level, level));
    AttributeSchema written = schema;
    if (request.narrow && schema.type == ComponentType::kFloat64)
      written.type = ComponentType::kFloat32;
    if (!holds_attribute(format, written)) {
      written.type = ComponentType::kFloat32;
      const bool narrows = schema.type == ComponentType::kFloat64 && is_gltf(format) &&
                           holds_attribute(format, written);
      throw Error(
          ErrorCode::kInvalidArgument,
          fmt::format("export {}: attribute '{}', {} x {}, cannot be written to {} files{}",
                      store.path().native(), name, to_string(schema.type), schema.components,
                      format_name(format), narrows ? "; --narrow writes it as float32" : ""));
    }
    if (std::ranges::find(chosen, id) != chosen.end())
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("export: attribute '{}' was given twice", name));
    chosen.push_back(id);
  }
  return chosen;
}

void check_face_attributes(const Store& store, MeshFormat format, const ExportRequest& request) {
  for (std::size_t at = 0; at < request.face_attributes.size(); ++at) {
    const std::string& name = request.face_attributes[at];
    std::as_const(store).notes().face_bytes(name);  // refuses unknown names
    const auto has_name = [&](const AttributeSchema& each) { return each.name == name; };
    if (!holds_face_attributes(format) ||
        !holds_attribute(format, *std::ranges::find_if(store.notes().face_attributes(), has_name)))
      throw Error(
          ErrorCode::kInvalidArgument,
          fmt::format("export {}: face attribute '{}' cannot be written to {} files; VTK files can "
                      "have all, PLY files all but integers of 64 bits",
                      store.path().native(), name, format_name(format)));
    if (std::ranges::find(request.face_attributes, name) !=
        request.face_attributes.begin() + static_cast<std::ptrdiff_t>(at))
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("export: face attribute '{}' was given twice", name));
  }
}

void check_counts(const Store& store, const PatchSelection& patches, MeshFormat format) {
  const bool ply = format == MeshFormat::kPly;
  if (!ply && format != MeshFormat::kStl) return;
  const std::uint64_t count = ply ? patches.vertex_count() : patches.triangle_count();
  if (count > kMaxCounted)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("export {}: {} {}, but {} files can have at most {}; take a coarser "
                            "--level, a --box, or OBJ",
                            store.path().native(), count, ply ? "vertices" : "triangles",
                            format_name(format), kMaxCounted));
}

/// The patches that the request asks for, ascending, each once.
std::vector<FaceId> chosen_faces(const Store& store, const ExportRequest& request) {
  const std::uint64_t count = store.base().face_count();
  std::vector<FaceId> faces;
  for (const FaceRange& range : request.faces) {
    if (range.last >= count)
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("export {}: face {}, expected 0 to {}", store.path().native(),
                              range.last, count - 1));
    for (FaceId face = range.first; face <= range.last; ++face) faces.push_back(face);
  }
  std::sort(faces.begin(), faces.end());
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
  if (request.faces.empty()) faces = all_faces(store.base());
  if (!request.box) return faces;
  const Reader reader(store, {.attributes = {"position"}});
  const std::vector<FaceId> near = reader.faces_in_box(*request.box);
  std::vector<FaceId> both;
  std::set_intersection(faces.begin(), faces.end(), near.begin(), near.end(),
                        std::back_inserter(both));
  if (both.empty())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("export {}: no patch meets the box", store.path().native()));
  return both;
}

void check_options(const Store& store, MeshFormat format, const ExportRequest& request) {
  const auto refuse = [&](std::string_view what) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("export {}: {}", store.path().native(), what));
  };
  if (!request.colors.empty() && request.colors != "srgb" && request.colors != "linear")
    refuse(fmt::format("colors '{}', expected srgb or linear", text_for_message(request.colors)));
  if (request.up != "y" && request.up != "z")
    refuse(fmt::format("up '{}', expected y or z", text_for_message(request.up)));
  if (request.pieces != 0 && format != MeshFormat::kPvtp) refuse("only .pvtp files have pieces");
  if (is_gltf(format)) return;
  if (request.quantize) refuse("only glTF files can be quantized");
  if (request.narrow) refuse("only glTF files need --narrow: others have float64, or decimals");
  if (!request.colors.empty())
    refuse("only glTF files say what colours are: others have the numbers of the store");
  if (request.up != "y")
    refuse("only glTF files say which axis is up: others have the axes of the store");
}

/// The text of such a file names others in UTF-8.
void check_name(const ExportRequest& request, MeshFormat format) {
  const std::string name = request.output.filename().string();
  if ((format == MeshFormat::kPvtp || format == MeshFormat::kGltf) &&
      (!is_utf8_text(name) || name.find_first_of("\t\n") != std::string::npos))
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("export to {}: the file would name others beside it, so expected a name "
                    "in UTF-8 without control characters; take another one, or .vtp or .glb",
                    request.output.native()));
}

/// The attributes that nobody asked for.
std::vector<std::string> others(const Store& store, AttributeId position,
                                std::span<const AttributeId> extras, const ExportRequest& request) {
  std::vector<std::string> names;
  for (AttributeId id = 0; id < store.attributes().size(); ++id)
    if (id != position && std::ranges::find(extras, id) == extras.end())
      names.push_back(store.attributes()[id].schema.name);
  for (const AttributeSchema& schema : store.notes().face_attributes())
    if (std::ranges::find(request.face_attributes, schema.name) == request.face_attributes.end())
      names.push_back(schema.name);
  return names;
}

bool has_normals(const Store& store, std::span<const AttributeId> extras) {
  return std::ranges::any_of(extras, [&](AttributeId id) {
    const AttributeSchema& schema = store.attributes()[id].schema;
    return schema.name == "normal" && schema.components == 3 &&
           (schema.type == ComponentType::kFloat32 || schema.type == ComponentType::kFloat64);
  });
}

/// Nothing if the file has no normals of sides.
std::optional<CreaseNormals> crease_normals(const ExportTask& task) {
  if (!has_normals(task.store, task.extras)) return std::nullopt;
  const CreasePoints points(task.store, task.level);
  const std::uint64_t count = points.vertex_count(task.store.base(), task.patches.faces());
  if (count == 0) return std::nullopt;
  const bool holds_sides = task.format == MeshFormat::kObj || is_gltf(task.format);
  if (holds_sides && !task.store.has_depths())
    return CreaseNormals(task.store, task.level, [&] { task.progress(0); });
  task.warn(fmt::format("export {}: {}{} vertices on sharp edges have one normal for all sides: {}",
                        task.store.path().native(), task.store.has_depths() ? "up to " : "", count,
                        holds_sides ? "a store without depths would have one for each"
                                    : ".obj, .glb and .gltf files have one for each"));
  return std::nullopt;
}

/// Writes the files under their temporary names.
ExportResult write_files(Store& store, OutputFiles& files, const ExportFormat& named,
                         const ExportRequest& request, const JobWatch& watch) {
  const MeshFormat format = named.mesh;
  check_options(store, format, request);
  const AttributeId position = position_of(store, "export");
  const int level = request.level >= 0 ? request.level : store.attributes()[position].finest_level;
  check_level(store, position, level);
  const std::vector<AttributeId> extras =
      chosen_attributes(store, position, level, format, request);
  check_face_attributes(store, format, request);
  const PatchSelection patches(store.base(),
                               relative_to_base(level, store.base_level()).refinements,
                               chosen_faces(store, request));
  check_counts(store, patches, format);

  ExportResult result;
  result.level = level;
  result.vertices = patches.vertex_count();
  result.triangles = patches.triangle_count();
  result.patches = patches.faces().size();
  result.left_out = others(store, position, extras, request);
  const std::uint64_t total = result.triangles + (format == MeshFormat::kStl ? 0 : result.vertices);
  const auto progress = [&](std::uint64_t done) {
    if (watch.progress && !watch.progress({"export", std::min(done, total), total}))
      throw Error(ErrorCode::kCancelled, "export: cancelled");
  };
  const auto warn = [&](const std::string& warning) {
    if (watch.warn) watch.warn(warning);
  };
  ExportTask task{store, request, format, level, position, extras, patches, progress, warn};
  const std::optional<CreaseNormals> creases = crease_normals(task);
  if (creases) task.creases = &*creases;
  if (is_gltf(format)) {
    const GltfOutcome outcome = write_gltf_level(task, files);
    result.vertices = outcome.vertices;
    result.file_bytes = outcome.file_bytes;
    result.moved = outcome.moved;
    if (outcome.without_normals) result.left_out.emplace_back("normal");
    result.side_normals = outcome.side_normals;
    return result;
  }
  if (format == MeshFormat::kPvtp) {
    result.file_bytes = write_pvtp_level(task, files);
    return result;
  }
  OutputStream output(files.main(), named.compression);
  if (format == MeshFormat::kPly) write_ply_level(task, output);
  if (format == MeshFormat::kObj) result.side_normals = write_obj_level(task, output);
  if (format == MeshFormat::kOff) write_off_level(task, output);
  if (format == MeshFormat::kStl) result.moved = write_stl_level(task, output);
  if (format == MeshFormat::kVtp) write_vtp_level(task, output);
  output.close();
  result.file_bytes = output.file_bytes();
  return result;
}

}  // namespace

std::vector<FaceColumn> face_columns(const ExportTask& task) {
  std::vector<FaceColumn> columns;
  for (const std::string& name : task.request.face_attributes)
    for (const AttributeSchema& schema : task.store.notes().face_attributes())
      if (schema.name == name)
        columns.push_back({schema, std::as_const(task.store).notes().face_bytes(name)});
  return columns;
}

ExportResult export_mesh(const ExportRequest& request, const BackendRegistry& backends,
                         const JobWatch& watch) {
  const ExportFormat format = export_format(request.output);
  check_name(request, format.mesh);
  if (watch.before_files) watch.before_files();
  OutputFiles files(request.output, request.existing, [&](const std::string& warning) {
    if (watch.warn) watch.warn(warning);
  });
  OpenOptions open;
  open.budget_bytes = request.budget_bytes;
  Store store = Store::open(request.store, open, backends);
  ExportResult result;
  try {
    result = write_files(store, files, format, request, watch);
  } catch (const Error& error) {
    throw files.named(error);
  }
  result.file = files.path();
  if (watch.progress && !watch.progress({"publish", 0, 1}))
    throw Error(ErrorCode::kCancelled, "export: cancelled");
  files.publish();
  return result;
}

PLAIT_END_NAMESPACE
