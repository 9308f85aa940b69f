#include "plait/extend/import_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "base/interruption.h"
#include "base/stopwatch.h"
#include "import/fine_mesh.h"
#include "job_rules.h"
#include "mesh/narrowing.h"
#include "mesh/weld.h"
#include "plait/error.h"
#include "plait/extend/notices.h"
#include "plait/extend/store_access.h"
#include "plait/patch_writer.h"
#include "plait/progress.h"
#include "plait/reader.h"
#include "plait/store_info.h"
#include "plait/subdivide.h"
#include "store/new_output.h"
#include "write_patches.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

class Import {
 public:
  Import(const ImportRequest& request, const BackendRegistry& backends, const JobWatch& watch)
      : request_(request), backends_(backends), watch_(watch), source_(request.mesh.native()) {
    UnpublishedStore::check(request.store, request.existing);
  }

  ImportResult run() {
    check_request();
    read();
    recover();
    result_.recover_seconds = clock_.lap();
    if (watch_.before_files) watch_.before_files();
    make_new_store(request_.store, request_.existing, request_.durability, watch_.warn,
                   [&](const std::filesystem::path& path) { make_store(path); });
    result_.write_seconds = clock_.lap();
    return std::move(result_);
  }

 private:
  void tell(std::string_view phase, std::uint64_t done = 0, std::uint64_t total = 1) {
    if (watch_.step && phase != step_) watch_.step(phase);
    step_ = phase;
    if (watch_.progress && !watch_.progress({phase, done, total}))
      throw Error(ErrorCode::kCancelled, fmt::format("import: cancelled, {}", phase));
  }
  void warn(const std::vector<std::string>& warnings) const {
    for (const std::string& warning : warnings)
      if (watch_.warn) watch_.warn(warning);
  }

  void check_request() const;
  void check_memory(std::uint64_t vertices, std::uint64_t attribute_bytes);
  void read();
  void recover();
  std::string sentence(const RecoveredLevels& found) const;
  StoreOptions options_of_store();
  void make_store(const std::filesystem::path& path);
  void write_patches(Store& store, std::span<const FaceSide> corners);

  const ImportRequest& request_;
  const BackendRegistry& backends_;
  const JobWatch& watch_;
  const std::string source_;
  std::string_view step_;
  Stopwatch clock_;
  FineMesh mesh_;
  RecoveredLevels found_;
  ImportResult result_;
};

void Import::check_request() const {
  if (request_.levels && (*request_.levels < 1 || *request_.levels > kMaxLevel))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("import {}: expected 1 to {} levels, found "
                            "{}",
                            source_, kMaxLevel, *request_.levels));
  if (request_.precision && *request_.precision != ComponentType::kFloat32 &&
      *request_.precision != ComponentType::kFloat64)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("import {}: expected precision float32 or float64, found {}", source_,
                            to_string(*request_.precision)));
  if (request_.backend == kAutomaticBackend) return;
  const RegisteredBackend& backend = backends_.find(request_.backend);
  backend.check_machine();
  if (!backend.traits.durable)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("import {}: expected a backend that stores levels in files, found {}",
                            source_, request_.backend));
  if (request_.pipeline_of && !backend.traits.compressed)
    throw needs_compression("import " + source_, backend);
}

void Import::check_memory(std::uint64_t vertices, std::uint64_t attribute_bytes) {
  result_.memory_bytes = vertices * import_bytes_per_vertex(attribute_bytes);
  plait::check_memory(fmt::format("import {}: {} vertices, beside the budget", source_, vertices),
                      result_.memory_bytes, request_.ignore_size);
}

void Import::read() {
  tell("read");
  check_memory(expected_vertices(request_.mesh), sizeof(Vector3<float>));
  std::vector<std::string> warnings;
  AttributedMesh read = read_attributed_mesh(request_.mesh, &warnings);
  if (request_.weld) result_.merged_vertices = weld(read, *request_.weld, source_, warnings);
  const ComponentType precision =
      precision_for(read.mesh, 0, request_.precision, read.precision, source_, warnings);
  warn(std::exchange(warnings, {}));
  mesh_ = fine_mesh(std::move(read), precision, source_);
  result_.read_seconds = clock_.lap();
  result_.vertices = mesh_.vertex_count;
  result_.faces = mesh_.faces.size();
  std::uint64_t attribute_bytes = 0;
  for (const MeshAttribute& attribute : mesh_.attributes) {
    result_.attributes.push_back(attribute.schema);
    attribute_bytes += attribute.schema.record_bytes();
  }
  // What was read is there already.
  tell("connect");
  check_memory(mesh_.vertex_count, attribute_bytes);
  connect(mesh_, source_, warnings);
  result_.seam_vertices = seam_vertices(mesh_);
  if (result_.seam_vertices > 0)
    warnings.push_back(fmt::format("{}: {}", source_, seam_text(result_.seam_vertices)));
  warn(warnings);
}

std::string Import::sentence(const RecoveredLevels& found) const {
  const RecoveryFailure& failure = *found.failure;
  return fmt::format(
      "found {} level{} of subdivision; the next one fails at vertex {}, which has {} "
      "faces{}: {}",
      found.meshes.size(), found.meshes.size() == 1 ? "" : "s", failure.vertex, failure.faces,
      failure.on_border ? " on a border" : "", failure.reason);
}

void Import::recover() {
  tell("levels");
  const int most = request_.levels.value_or(kMaxLevel);
  found_ = recover_levels(mesh_.view(), most, [&](int levels) {
    tell("levels", static_cast<std::uint64_t>(levels), static_cast<std::uint64_t>(most));
  });
  const int levels = static_cast<int>(found_.meshes.size());
  if (found_.failure && levels < request_.levels.value_or(1))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("import {}: {}; for a mesh without such levels, take plait remesh",
                            source_, sentence(found_)));
  if (found_.failure) result_.next_level = sentence(found_);
  result_.levels = levels;
  result_.had_choice = found_.had_choice;
  result_.base_level = rebase_levels(levels, mesh_.attributes[0].schema.record_bytes(),
                                     request_.max_slot_bytes.value_or(kLargestSlotBytes));
}

StoreOptions Import::options_of_store() {
  std::uint64_t record_bytes = 0;
  for (const AttributeSchema& schema : result_.attributes) record_bytes += schema.record_bytes();
  BackendChoice choice{request_.backend, "given by the user"};
  if (request_.backend == kAutomaticBackend)
    choice = backends_.choose({.path = request_.store,
                               .level_bytes = mesh_.vertex_count * record_bytes,
                               .has_pipelines = static_cast<bool>(request_.pipeline_of)});
  const RegisteredBackend& backend = backends_.find(choice.name);
  StoreOptions options;
  options.backend = result_.backend = choice.name;
  result_.backend_reason = choice.reason;
  options.block_bytes = request_.block_bytes;
  options.budget_bytes = request_.budget_bytes;
  options.durability = request_.durability;
  if (request_.no_index) options.base_index = false;
  options.parallel_for = request_.parallel_for;
  if (!request_.pipeline_of) return options;
  for (const AttributeSchema& schema : result_.attributes)
    backend.check_pipelines(request_.pipeline_of(schema), schema);
  options.pipeline_of = request_.pipeline_of;
  return options;
}

/// The corners of the faces of a mesh that has the faces of `base` in another order.
std::vector<FaceSide> corners_in_order(const ImportedBase& base, const BaseMesh& laid_out) {
  std::vector<FaceId> sorted(base.mesh.face_count());
  for (FaceId face = 0; face < sorted.size(); ++face) sorted[face] = face;
  std::uint64_t turn = 0;
  const auto corners_of = [&](FaceId face) -> const FaceVertices& {
    if (is_turn_to_poll(++turn)) poll_interruption();
    return base.mesh.faces()[face];
  };
  std::ranges::sort(sorted, {}, corners_of);
  std::vector<FaceSide> corners;
  for (const FaceVertices& face : laid_out.faces())
    corners.push_back(base.corners[*std::ranges::lower_bound(sorted, face, {}, corners_of)]);
  return corners;
}

void Import::make_store(const std::filesystem::path& path) {
  tell("lay out");
  const auto level = static_cast<std::size_t>(result_.levels - result_.base_level) - 1;
  ImportedBase base = imported_base(mesh_, found_.meshes[level], source_);
  found_.meshes.clear();
  LaidOutMesh laid_out = lay_out(base.mesh, request_.layout);
  const std::vector<FaceSide> corners = corners_in_order(base, laid_out.mesh);
  base = {};
  result_.base_vertices = laid_out.mesh.vertex_count();
  result_.base_faces = laid_out.mesh.face_count();
  result_.border_edges = laid_out.mesh.border_edge_count();
  Store store = Store::create(path, std::move(laid_out), options_of_store(), backends_,
                              {.base_level = result_.base_level});
  tell_notices(store, watch_.warn, request_.store);
  for (const MeshAttribute& attribute : mesh_.attributes)
    store.add_attribute(attribute.schema, result_.levels);
  write_patches(store, corners);
  mesh_ = {};
  store.finish_encoding([&](const Progress& now) {
    tell("encode", now.done, now.total);
    return true;
  });
  tell("commit");
  store.commit();
  result_.stored_bytes = store.info().stored_bytes;
  store.close();
}

void Import::write_patches(Store& store, std::span<const FaceSide> corners) {
  tell("write");
  const FinestMesh mesh = mesh_.view();
  const int refinements = result_.levels - result_.base_level;
  const std::uint64_t count = patch_vertex_count(std::int64_t{1} << refinements);
  // Many patches at once, but not many vertices.
  const auto faces_at_once = static_cast<FaceId>(std::clamp<std::uint64_t>(16384 / count, 1, 32));
  const auto faces = static_cast<FaceId>(corners.size());
  const auto fill = [&](PatchWriter& writer, FaceId first, FaceId after) {
    std::vector<VertexId> vertices((after - first) * count);
    std::vector<std::byte> records;
    walk_patches(mesh, corners.subspan(first, after - first), refinements, vertices.data());
    for (FaceId face = first; face < after; ++face) {
      const std::span<VertexId> of_patch =
          std::span(vertices).subspan((face - first) * count, count);
      for (VertexId& vertex : of_patch) vertex = mesh.file_vertex(vertex);
      for (const MeshAttribute& attribute : mesh_.attributes) {
        gather_records(attribute, of_patch, records);
        writer.write_patch_of_bytes(attribute.schema.name, face, result_.levels, records);
      }
    }
  };
  std::size_t largest = 0;
  for (const MeshAttribute& attribute : mesh_.attributes)
    largest = std::max(largest, attribute.schema.record_bytes());
  const auto begins = [&](int threads) {
    warn_of_fewer_threads("import " + source_, threads, request_.threads,
                          store.options().budget_bytes, watch_.warn);
  };
  plait::write_patches(store,
                       {.job = "import",
                        .threads = request_.threads,
                        .faces_at_once = faces_at_once,
                        .scratch_bytes = count * (faces_at_once * sizeof(VertexId) + largest),
                        .begins = begins,
                        .fill = fill,
                        .report = [&](FaceId done) { tell("write", done, faces); }});
}

}  // namespace

ImportResult import_mesh(const ImportRequest& request, const BackendRegistry& backends,
                         const JobWatch& watch) try {
  ImportRequest counted = request;
  counted.threads = thread_count(request.threads, "import " + request.mesh.native());
  return Import(counted, backends, watch).run();
} catch (const std::bad_alloc&) {
  throw out_of_memory("import " + request.mesh.native());
}

PLAIT_END_NAMESPACE
