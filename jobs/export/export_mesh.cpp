#include "export/export_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <utility>

#include "export/format_writers.h"
#include "export/output_files.h"
#include "plait/reader.h"

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
    if (!holds_attribute(format, schema))
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("export {}: attribute '{}', {} x {}, cannot be written to {} files",
                              store.path().native(), name, to_string(schema.type),
                              schema.components, format_name(format)));
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
    std::as_const(store).face_bytes(name);  // refuses unknown names
    const auto has_name = [&](const AttributeSchema& each) { return each.name == name; };
    if (!holds_face_attributes(format) ||
        !holds_attribute(format, *std::ranges::find_if(store.face_attributes(), has_name)))
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

void check_position(const Store& store, AttributeId position) {
  const AttributeSchema& schema = store.attributes()[position].schema;
  if (schema.components != 3 ||
      (schema.type != ComponentType::kFloat32 && schema.type != ComponentType::kFloat64))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("export {}: attribute 'position' holds {} x {}, expected float32 x 3 "
                            "or float64 x 3",
                            store.path().native(), to_string(schema.type), schema.components));
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
  if (request.quantize && !is_gltf(format))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("export {}: only glTF files can be quantized", store.path().native()));
  if (request.pieces != 0 && format != MeshFormat::kPvtp)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("export {}: only .pvtp files have pieces", store.path().native()));
}

/// Writes the files under their temporary names.
ExportResult write_files(Store& store, OutputFiles& files, const ExportFormat& named,
                         const ExportRequest& request, const ExportWatch& watch) {
  const MeshFormat format = named.mesh;
  check_options(store, format, request);
  const AttributeId position = store.attribute("position");
  check_position(store, position);
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
  const std::uint64_t total = result.triangles + (format == MeshFormat::kStl ? 0 : result.vertices);
  const auto progress = [&](std::uint64_t done) {
    if (watch.progress && !watch.progress({"export", std::min(done, total), total}))
      throw Error(ErrorCode::kCancelled, "export: cancelled");
  };
  const ExportTask task{store, request, format, level, position, extras, patches, progress};
  if (is_gltf(format)) {
    const GltfOutcome outcome = write_gltf_level(task, files);
    result.vertices = outcome.vertices;
    result.file_bytes = outcome.file_bytes;
    result.position_error = outcome.position_error;
    return result;
  }
  if (format == MeshFormat::kPvtp) {
    result.file_bytes = write_pvtp_level(task, files);
    return result;
  }
  OutputStream output(files.main(), named.compression);
  if (format == MeshFormat::kPly) write_ply_level(task, output);
  if (format == MeshFormat::kObj) write_obj_level(task, output);
  if (format == MeshFormat::kOff) write_off_level(task, output);
  if (format == MeshFormat::kStl) write_stl_level(task, output);
  if (format == MeshFormat::kVtp) write_vtp_level(task, output);
  output.close();
  result.file_bytes = output.file_bytes();
  return result;
}

}  // namespace

std::vector<FaceColumn> face_columns(const ExportTask& task) {
  std::vector<FaceColumn> columns;
  for (const std::string& name : task.request.face_attributes)
    for (const AttributeSchema& schema : task.store.face_attributes())
      if (schema.name == name)
        columns.push_back({schema, std::as_const(task.store).face_bytes(name)});
  return columns;
}

ExportResult export_mesh(const ExportRequest& request, const BackendRegistry& backends,
                         const ExportWatch& watch) {
  const ExportFormat format = export_format(request.output);
  OutputFiles files(request.output, [&](const std::string& warning) {
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
  if (watch.before_publish) watch.before_publish();
  files.publish();
  return result;
}

PLAIT_END_NAMESPACE
