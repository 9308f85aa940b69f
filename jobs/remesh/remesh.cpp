#include "remesh/remesh.h"

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <functional>
#include <optional>
#include <utility>

#include "base/stopwatch.h"
#include "export/crease_normals.h"
#include "import/fine_mesh.h"
#include "job_rules.h"
#include "mesh/narrowing.h"
#include "mesh/weld.h"
#include "plait/compression.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/extend/attributed_mesh.h"
#include "plait/extend/copy_levels.h"
#include "plait/extend/notices.h"
#include "plait/extend/store_access.h"
#include "plait/notes.h"
#include "plait/progress.h"
#include "plait/registry.h"
#include "plait/store.h"
#include "plait/store_info.h"
#include "remesh/base_samples.h"
#include "remesh/choose_depths.h"
#include "remesh/distance_search.h"
#include "remesh/sampled_surface.h"
#include "remesh/scan_attributes.h"
#include "remesh/scan_face_attributes.h"
#include "remesh/scan_progress.h"
#include "store/new_output.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::uint64_t kBytesPerScanFace = 200;
constexpr std::uint64_t kBytesPerSmallFace = 140;
constexpr std::uint64_t kBytesPerFaceOfAllLevels = 60;  ///< of a store in memory
constexpr std::uint64_t kFacesPerVertex = 2;
constexpr int kFarEdges = 3;  ///< of the mean length: a part of the scan farther away is a warning
const Provenance kProvenance = {.layout = "hilbert"};
constexpr std::string_view kTurned = "turned", kDistance = "distance", kRemeshRms = "remesh-rms";
/// relax() numbers the corners of small faces in 32 bits.
constexpr std::uint64_t kMostSmallFaces = (std::uint64_t{1} << 32) / 3;

constexpr WorkPart kSampling = {0, 700}, kMeasuringStore = {700, 780}, kMeasuringScan = {780, 870},
                   kWriting = {870, 930}, kWritingAttributes = {930, 970}, kEncoding = {970, 1000};
/// With depths, what is written was measured before.
constexpr WorkPart kFillingMemory = {700, 720}, kChoosingDepths = {720, 900},
                   kCopyingLevels = {900, 1000};
/// Of a trial of search().
constexpr WorkPart kTrialSampling = {0, 800}, kTrialStore = {800, 900}, kTrialScan = {900, 1000};

/// How many levels the small faces are finer than those of the scan.
int levels_finer_than(std::uint64_t scan_faces, const RemeshRequest& request) {
  if (request.max_distance) return 1;  // DistanceSearch::levels()
  int levels = 0;
  for (std::uint64_t faces = request.faces << (2 * request.levels); faces > scan_faces; faces /= 4)
    ++levels;
  return levels;
}

/// The store has attributes of its own.
void leave_out_own_names(std::vector<MeshAttribute>& attributes, bool distances,
                         std::vector<std::string>& warnings) {
  std::erase_if(attributes, [&](const MeshAttribute& attribute) {
    const std::string& name = attribute.schema.name;
    if (name != kTurned && !(distances && name == kDistance)) return false;
    warnings.push_back(
        fmt::format("attribute '{}' of the scan left out: the store has its own", name));
    return true;
  });
}

class ScanRun {
 public:
  ScanRun(const RemeshRequest& request, const BackendRegistry& backends, const JobWatch& watch)
      : request_(request), backends_(backends), watch_(watch), progress_(watch.progress) {}

  RemeshReport run() {
    check_request();
    read_scan();
    scan_tree_.emplace(scan_.positions, scan_.faces, [this] { progress_.begin("repair", 0); });
    if (request_.max_distance)
      search();
    else
      sampled_ = make_base_samples(request_, scan_, *scan_tree_, kSampling, progress_, report_);
    report_.faces_asked = request_.faces;
    report_.levels = request_.levels;
    if (watch_.warn && report_.faces_for_creases > 0)
      watch_.warn(fmt::format(
          "remesh {}: sharp edges of the scan become round: a base mesh that "
          "keeps them has {} faces or more: take --faces {}, or --feature-angle "
          "none if none shall be kept",
          request_.scan.native(), report_.faces_for_creases, report_.faces_for_creases));
    if (!request_.max_distance && (request_.distances || request_.report_samples > 0))
      set_triangles(small_triangles(sampled_.surface), kSampling.last);
    if (request_.distances) {
      progress_.begin("distances", kSampling.last);
      sampled_.surface.distances = distances_at_samples(scan_, triangles_->mesh, triangles_->tree);
    }
    if (request_.report_samples > 0 && !request_.max_distance) {
      measure(kMeasuringStore, kMeasuringScan, kFarEdges * report_.mean_edge);
      if (watch_.warn && report_.to_store.far_share > 0) watch_.warn(far_text());
    }
    if (request_.report_samples > 0) count_crossings();
    triangles_.reset();
    if (report_.max_distance > 0 && request_.own_depths.value_or(true)) give_depths();
    if (!of_scan_faces_.empty())
      of_base_faces_ = of_scan_faces_.of_base_faces(scan_, *scan_tree_, sampled_.surface, [&] {
        progress_.begin("face attributes", all_levels_ ? kCopyingLevels.first : kWriting.first);
      });
    make_store();
    return std::move(report_);
  }

 private:
  void check_request() const;
  void check_memory(std::uint64_t scan_faces) const;
  void warn_of_fewer(std::string_view step, const Store& store, int threads) const {
    warn_of_fewer_threads(step, threads, request_.threads, store.options().budget_bytes,
                          watch_.warn);
  }
  void check_counts() const;
  void read_scan();
  void search();
  [[noreturn]] void refuse_distance(double found) const;
  void make_store();
  void write_store(const std::filesystem::path& path);
  void fill(Store& store, WorkPart writing, WorkPart writing_attributes);
  void give_depths();
  void set_triangles(IndexedMesh mesh, std::uint64_t thousandths);
  /// Of the present triangles.
  void measure(WorkPart to_store, WorkPart to_scan, double far);
  std::string far_text() const;
  void count_crossings();
  std::string crossings_remedy() const;
  bool sheets_coincide(const Point& p) const;

  /// Triangles of the store that are measured, and a tree that points into them.
  struct MeasuredTriangles {
    MeasuredTriangles(IndexedMesh triangles, const std::function<void()>& go_on)
        : mesh(std::move(triangles)), tree(mesh.positions, mesh.faces, go_on) {}
    MeasuredTriangles(const MeasuredTriangles&) = delete;
    MeasuredTriangles& operator=(const MeasuredTriangles&) = delete;

    const IndexedMesh mesh;
    const TriangleTree tree;
  };

  RemeshRequest request_;  ///< search() sets faces and levels
  const BackendRegistry& backends_;
  const JobWatch& watch_;
  ScanProgress progress_;
  RemeshReport report_;
  Surface scan_;
  std::optional<TriangleTree> scan_tree_;
  ScanAttributes attributes_;
  ScanFaceAttributes of_scan_faces_;
  std::vector<BaseFaceAttribute> of_base_faces_;
  BaseSamples sampled_;
  std::optional<MeasuredTriangles> triangles_;
  std::optional<Store> all_levels_;  ///< in memory, if the store has depths
  BaseMesh base_of_store_;           ///< with the depths
  double farthest_vertex_ = 0;       ///< of the scan, if the store has depths
};

void ScanRun::check_request() const {
  if (request_.faces < 1 && !request_.max_distance)
    throw JobError(ErrorCode::kInvalidArgument,
                   "remesh: expected a number of faces or a largest distance, found neither",
                   "faces");
  if (request_.max_distance && !(request_.max_distance->number > 0))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("remesh: largest distance: expected more than 0, found {}",
                            request_.max_distance->number));
  if (request_.max_distance && request_.report_samples == 0)
    throw Error(ErrorCode::kInvalidArgument,
                "remesh: expected 1 sample or more to measure the largest distance, found 0");
  if (request_.own_depths.value_or(false) && !request_.max_distance)
    throw JobError(ErrorCode::kInvalidArgument,
                   "remesh: depths of their own: expected a largest distance, which says how deep "
                   "faces are, found none",
                   "max-distance");
  if (request_.precision && *request_.precision != ComponentType::kFloat32 &&
      *request_.precision != ComponentType::kFloat64)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("remesh: precision: expected float32 or float64, found {}",
                            to_string(*request_.precision)));
  if (request_.levels < 1 || request_.levels > 12)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("remesh: levels: expected 1 to 12, found {}", request_.levels));
  check_counts();
  if (request_.options.pipeline_of && request_.options.backend != kAutomaticBackend)
    if (const RegisteredBackend& backend = backends_.find(request_.options.backend);
        !backend.traits.compressed)
      throw needs_compression("remesh " + request_.scan.native(), backend);
  UnpublishedStore::check(request_.store, request_.existing);
}

void ScanRun::check_counts() const {
  if (request_.faces > kMostSmallFaces >> (2 * request_.levels))
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("remesh: expected at most {} faces of the base mesh at level {}, found "
                    "{}",
                    kMostSmallFaces >> (2 * request_.levels), request_.levels, request_.faces));
}

void ScanRun::check_memory(std::uint64_t scan_faces) const {
  const std::uint64_t base_faces = std::min(request_.faces, scan_faces);
  const bool prunes = request_.max_distance && request_.own_depths.value_or(true);
  const std::uint64_t needed = scan_faces * kBytesPerScanFace +
                               (base_faces << (2 * request_.levels)) *
                                   (kBytesPerSmallFace + (prunes ? kBytesPerFaceOfAllLevels : 0)) +
                               request_.options.budget_bytes;
  plait::check_memory(fmt::format("remesh {}: {} faces and {} small faces", request_.scan.native(),
                                  scan_faces, base_faces << (2 * request_.levels)),
                      needed, request_.ignore_size);
}

void ScanRun::read_scan() {
  Stopwatch clock;
  progress_.begin("read", 0);
  check_memory(kFacesPerVertex * expected_vertices(request_.scan));
  std::vector<std::string> warnings;
  AttributedMesh mesh =
      read_attributed_mesh(request_.scan, &warnings, NotFinite::kKeep, OfFaces::kKeep);
  leave_out_own_names(mesh.attributes, request_.distances, warnings);
  std::erase_if(mesh.face_attributes, [&](const MeshAttribute& attribute) {
    if (attribute.schema.name != kCreaseSides) return false;
    warnings.push_back(
        fmt::format("property {} of the faces of the scan left out: it is what the store says of "
                    "its own sharp edges",
                    kCreaseSides));
    return true;
  });
  if (request_.weld)
    report_.merged_vertices = weld(mesh, *request_.weld, request_.scan.native(), warnings);
  warn_of_values_not_finite(mesh, warnings);
  report_.precision = precision_for(mesh.mesh, levels_finer_than(mesh.mesh.faces.size(), request_),
                                    request_.precision, {}, request_.scan.native(), warnings);
  report_.read_seconds = clock.lap();
  check_memory(mesh.mesh.faces.size());
  const auto go_on = [&] { progress_.begin("repair", 0); };
  go_on();
  Repaired repaired = repair(std::move(mesh.mesh), request_.repair, request_.scan.native());
  go_on();
  report_.mean_edge = mean_edge_of({repaired.surface.positions, repaired.surface.faces});
  report_.lost_step = lost_step(repaired.surface.positions, report_.mean_edge);
  if (report_.lost_step > 0)
    warnings.push_back(fmt::format(
        "{}: coordinates have steps of {:.3g}, {:.2g} mean edges, because their other digits were "
        "lost before: write the scan as float64, or relative to a point near it",
        request_.scan.native(), report_.lost_step, report_.lost_step / report_.mean_edge));
  report_.seam_vertices = repaired.seam_vertices;
  if (repaired.seam_vertices > 0)
    warnings.push_back(fmt::format(
        "{}: {}", request_.scan.native(),
        report_.lost_step > 0 ? seam_text(repaired.seam_vertices, "the lost digits told them apart")
                              : seam_text(repaired.seam_vertices)));
  if (watch_.warn)
    for (const std::string& warning : warnings) watch_.warn(warning);
  go_on();
  attributes_ = ScanAttributes(std::move(mesh.attributes), repaired);
  of_scan_faces_ =
      ScanFaceAttributes(std::move(mesh.face_attributes), std::move(repaired.face_origin));
  scan_ = std::move(repaired.surface);
  report_.repairs = repaired.list;
  report_.scan = figures_of(scan_);
  go_on();
  report_.diagonal = diagonal_of({scan_.positions, scan_.faces});
  report_.repair_seconds = clock.lap();
}

void ScanRun::make_store() {
  const Stopwatch clock;
  if (watch_.before_files) watch_.before_files();
  make_new_store(request_.store, request_.existing, request_.options.durability, watch_.warn,
                 [&](const std::filesystem::path& path) {
                   write_store(path);
                   report_.write_seconds = clock.seconds();
                   progress_.begin("publish", 1000);
                 });
}

void ScanRun::write_store(const std::filesystem::path& path) {
  StoreOptions options = request_.options;
  const SampledSurface& surface = sampled_.surface;
  options.expected_bytes = surface.positions.size() * 3 * component_bytes(report_.precision);
  if (options.pipeline_of && report_.rounding)
    options.pipeline_of = [pipeline_of = options.pipeline_of,
                           step = report_.rounding->step](const AttributeSchema& schema) {
      const LevelPipelines pipelines = pipeline_of(schema);
      return schema.name == "position" ? pipeline_of_rounded(pipelines, step) : pipelines;
    };
  Store store = Store::create(path, BaseMesh(all_levels_ ? base_of_store_ : surface.base), options,
                              backends_, kProvenance);
  tell_notices(store, watch_.warn, request_.store);
  if (all_levels_)
    copy_levels(*all_levels_, store, progress_.during(kCopyingLevels));
  else
    fill(store, kWriting, kWritingAttributes);
  for (std::size_t at = 0; at < attributes_.count(); ++at)
    report_.attributes.push_back(attributes_.schema(at));
  if (!surface.crease_sides.empty()) {
    store.notes().add_face_attribute(schema_of<std::uint8_t>(std::string(kCreaseSides)));
    std::ranges::copy(surface.crease_sides,
                      store.notes().face_records<std::uint8_t>(kCreaseSides).begin());
  }
  for (const auto& [numbers, mixed_faces] : of_base_faces_) {
    store.notes().add_face_attribute(numbers.schema);
    std::ranges::copy(numbers.records, store.notes().face_bytes(numbers.schema.name).begin());
    report_.face_attributes.push_back(numbers.schema);
    report_.mixed_faces.push_back(mixed_faces);
  }
  if (!all_levels_) store.finish_encoding(progress_.during(kEncoding));
  if (report_.rounding)
    StoreAccess::set_rounding(store, store.attribute("position"), report_.rounding);
  // What a later rounding may add to (plait tune).
  if (request_.report_samples > 0)
    store.notes().set_text(
        kRemeshRms, fmt::format("{:.9g}", std::max(report_.to_store.rms, report_.to_scan.rms)));
  store.commit();
  report_.backend = store.options().backend;
  report_.stored_bytes = store.info().stored_bytes;
  if (request_.digest) {
    DigestOptions how;
    how.threads = request_.threads;
    how.begins = [&](int threads) { warn_of_fewer("digest", store, threads); };
    report_.digest = digest(store, how).to_string();
  }
  store.close();
}

void ScanRun::fill(Store& store, WorkPart writing, WorkPart writing_attributes) {
  const SampledSurface& surface = sampled_.surface;
  write_levels(surface, report_.precision, store, request_.threads, progress_.during(writing));
  const auto begins = [&](int threads) { warn_of_fewer("attributes", store, threads); };
  write_attributes(attributes_, scan_, sampled_.samples, surface, store,
                   {request_.threads, progress_.during(writing_attributes), begins});
}

/// From all levels, in memory.
void ScanRun::give_depths() {
  const Stopwatch clock;
  StoreOptions options;
  options.backend = "memory";
  options.budget_bytes = request_.options.budget_bytes;
  options.parallel_for = request_.options.parallel_for;
  all_levels_.emplace(
      Store::create({}, BaseMesh(sampled_.surface.base), options, default_backends(), kProvenance));
  fill(*all_levels_, kFillingMemory.nth(0, 2), kFillingMemory.nth(1, 2));
  report_.prune_seconds += clock.seconds();
  base_of_store_ = choose_depths(
      *all_levels_, sampled_.surface, kChoosingDepths, progress_,
      [&](const IndexedMesh& drawn, WorkPart to_store, WorkPart to_scan) {
        set_triangles(drawn, to_store.first);
        measure(to_store, to_scan, report_.max_distance);
        return std::max({report_.to_store.max, report_.to_scan.max, farthest_vertex_});
      },
      report_);
}

void ScanRun::search() {
  const double limit = request_.max_distance->of(report_.diagonal);
  report_.max_distance = limit;
  DistanceSearch search(scan_.faces.size(), request_.faces, request_.levels);
  // How many trials it will be is not known. Each takes half of the work that is left.
  for (WorkPart left = kSampling;; left = left.nth(1, 2)) {
    const WorkPart now = left.nth(0, 2);
    request_.faces = search.faces();
    request_.levels = search.levels();
    check_counts();
    check_memory(scan_.faces.size());
    ++report_.trials;
    report_.base_meshes = 0;
    sampled_ =
        make_base_samples(request_, scan_, *scan_tree_, now.of(kTrialSampling), progress_, report_);
    set_triangles(small_triangles(sampled_.surface), now.of(kTrialStore).first);
    measure(now.of(kTrialStore), now.of(kTrialScan), limit);
    const double found = std::max(report_.to_store.max, report_.to_scan.max);
    if (found <= limit) return;
    if (!search.next(found / limit)) refuse_distance(found);
  }
}

void ScanRun::refuse_distance(double found) const {
  std::string places;
  for (const Distances* const direction : {&report_.to_store, &report_.to_scan})
    for (const FarPlace& place : direction->far_places)
      places += fmt::format("{} ({:.6g}, {:.6g}, {:.6g}): {:.3g}", places.empty() ? "" : ",",
                            place.at.x, place.at.y, place.at.z, place.distance);
  throw Error(
      ErrorCode::kInvalidArgument,
      fmt::format("remesh {}: expected no point farther than {:.6g}, found {:.6g} with the "
                  "last of {} base meshes, which has {} faces and the scan {}, around{}: "
                  "take a larger distance{}",
                  request_.scan.native(), report_.max_distance, found, report_.trials,
                  report_.base.faces, report_.scan.faces, places,
                  report_.precision == ComponentType::kFloat32 ? " or --precision float64" : ""));
}

void ScanRun::set_triangles(IndexedMesh mesh, std::uint64_t thousandths) {
  const Stopwatch clock;
  triangles_.emplace(std::move(mesh), [&] { progress_.begin("distances", thousandths); });
  report_.report_seconds += clock.seconds();
}

void ScanRun::measure(WorkPart to_store, WorkPart to_scan, double far) {
  const Stopwatch clock;
  const TriangleTree& store_tree = triangles_->tree;
  const TriangleSet scan{scan_.positions, scan_.faces},
      store{triangles_->mesh.positions, triangles_->mesh.faces};
  report_.to_store = measure_distances(scan, store_tree, store,
                                       {.samples = request_.report_samples,
                                        .far = far,
                                        .phase = "distance to the store",
                                        .progress = progress_.during(to_store)});
  if (all_levels_) farthest_vertex_ = farthest_vertex(scan_, store_tree);
  report_.to_scan = measure_distances(store, *scan_tree_, scan,
                                      {.samples = request_.report_samples,
                                       .far = far,
                                       .phase = "distance to the scan",
                                       .progress = progress_.during(to_scan)});
  report_.report_seconds += clock.seconds();
}

/// The parts of the scan that are far from the store, and what helps.
std::string ScanRun::far_text() const {
  const Distances& found = report_.to_store;
  std::string text;
  for (const FarPlace& place : found.far_places)
    text += fmt::format("{} around ({:.6g}, {:.6g}, {:.6g}), up to {:.3g} % of the diagonal",
                        text.empty() ? "" : ",", place.at.x, place.at.y, place.at.z,
                        100 * place.distance / report_.diagonal);
  return fmt::format(
      "remesh {}: {:.2g} % of the scan is more than {} mean edges away from the store:{}: take "
      "more "
      "faces, as with --faces {}{}",
      request_.scan.native(), 100 * found.far_share, kFarEdges, text, 4 * report_.base.faces,
      request_.levels > 1
          ? fmt::format(" --levels {}, which makes as many vertices", request_.levels - 1)
          : std::string());
}

/// Sheets that are nearer to each other than the store is to the scan may pass through each other,
/// and no distance shows it.
void ScanRun::count_crossings() {
  const Stopwatch clock;
  // Depths come afterwards.
  const auto go_on = [this] {
    progress_.begin("crossings", request_.max_distance ? kSampling.last : kMeasuringScan.last);
  };
  const TriangleSet scan{scan_.positions, scan_.faces},
      store{triangles_->mesh.positions, triangles_->mesh.faces};
  report_.scan_crossings = find_crossings(scan, *scan_tree_, go_on);
  report_.crossings = find_crossings(store, triangles_->tree, go_on);
  report_.report_seconds += clock.seconds();
  if (!watch_.warn) return;
  if (report_.scan_crossings.examined < scan.faces.size() ||
      report_.crossings.examined < store.faces.size())
    watch_.warn(fmt::format(
        "remesh {}: faces that pass through others were looked for among the first {} of {} faces "
        "of the scan and {} of {} small faces alone: nearly all of them reach across others",
        request_.scan.native(), report_.scan_crossings.examined, scan.faces.size(),
        report_.crossings.examined, store.faces.size()));
  if (report_.crossings.faces <= report_.scan_crossings.faces) return;
  const Point at = report_.crossings.first;
  watch_.warn(
      fmt::format("remesh {}: {} small faces pass through others, and {} faces of the scan do, "
                  "first around ({:.6g}, {:.6g}, {:.6g}): {}",
                  request_.scan.native(), report_.crossings.faces, report_.scan_crossings.faces,
                  at.x, at.y, at.z, crossings_remedy()));
}

std::string ScanRun::crossings_remedy() const {
  if (report_.lost_step > 0)
    return "faces of the scan are turned by its lost digits, and more faces do not help";
  if (sheets_coincide(report_.crossings.first))
    return "sheets of the scan lie on each other there, which more faces do not part: --weld makes "
           "them one";
  return fmt::format("take more faces where sheets are so near to each other, as with --faces {}",
                     4 * report_.base.faces);
}

/// Whether other vertices of the scan are where those of the face nearest to `p` are.
bool ScanRun::sheets_coincide(const Point& p) const {
  const std::array<VertexId, 3>& face = scan_.faces[scan_tree_->closest(p).face];
  return std::ranges::count_if(face, [&](VertexId corner) {
           return std::ranges::count(scan_.positions, scan_.positions[corner]) > 1;
         }) > 1;
}

}  // namespace

RemeshReport remesh(const RemeshRequest& request, const BackendRegistry& backends,
                    const JobWatch& watch) {
  return with_memory_errors("remesh " + request.scan.native(), [&] {
    RemeshRequest counted = request;
    counted.threads = thread_count(request.threads, "remesh");
    RemeshReport report;
    tbb::task_arena(counted.threads).execute([&] {
      report = ScanRun(counted, backends, watch).run();
    });
    return report;
  });
}

PLAIT_END_NAMESPACE
