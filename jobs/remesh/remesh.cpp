#include "remesh/remesh.h"

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <utility>

#include "base/stopwatch.h"
#include "export/crease_normals.h"
#include "job_rules.h"
#include "plait/compression.h"
#include "plait/digest.h"
#include "plait/error.h"
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
#include "remesh/measured_store.h"
#include "remesh/read_scan.h"
#include "remesh/sampled_surface.h"
#include "remesh/scan_progress.h"
#include "store/new_output.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

const Provenance kProvenance = {.layout = "hilbert"};
constexpr std::string_view kRemeshRms = "remesh-rms";
/// relax() numbers the corners of small faces in 32 bits.
constexpr std::uint64_t kMostSmallFaces = (std::uint64_t{1} << 32) / 3;

constexpr WorkPart kSampling = {0, 700}, kMeasuringStore = {700, 780}, kMeasuringScan = {780, 870},
                   kWriting = {870, 930}, kWritingAttributes = {930, 970}, kEncoding = {970, 1000};
/// With depths, what is written was measured before.
constexpr WorkPart kFillingMemory = {700, 720}, kChoosingDepths = {720, 900},
                   kCopyingLevels = {900, 1000};
/// Of a trial of search().
constexpr WorkPart kTrialSampling = {0, 800}, kTrialStore = {800, 900}, kTrialScan = {900, 1000};

class ScanRun {
 public:
  ScanRun(const RemeshRequest& request, const BackendRegistry& backends, const JobWatch& watch)
      : request_(request), backends_(backends), watch_(watch), progress_(watch.progress) {}

  RemeshReport run() {
    check_request();
    scan_ = read_scan(request_, progress_, watch_, report_);
    scan_tree_.emplace(scan_.surface.positions, scan_.surface.faces,
                       [this] { progress_.begin("repair", 0); });
    store_.emplace(request_, scan_.surface, *scan_tree_, progress_, watch_, report_);
    if (request_.max_distance)
      search();
    else
      sampled_ =
          make_base_samples(request_, scan_.surface, *scan_tree_, kSampling, progress_, report_);
    report_.faces_asked = request_.faces;
    report_.levels = request_.levels;
    if (watch_.warn && report_.faces_for_creases > 0)
      watch_.warn(fmt::format(
          "remesh {}: sharp edges of the scan become round: a base mesh that "
          "keeps them has {} faces or more: take --faces {}, or --feature-angle "
          "none if none shall be kept",
          request_.scan.native(), report_.faces_for_creases, report_.faces_for_creases));
    if (!request_.max_distance && (request_.distances || request_.report_samples > 0))
      store_->set_triangles(small_triangles(sampled_.surface), kSampling.last);
    if (request_.distances) {
      progress_.begin("distances", kSampling.last);
      sampled_.surface.distances =
          distances_at_samples(scan_.surface, store_->mesh(), store_->tree());
    }
    if (request_.report_samples > 0 && !request_.max_distance) {
      store_->measure(kMeasuringStore, kMeasuringScan,
                      MeasuredStore::kFarEdges * report_.mean_edge);
      store_->warn_of_far_places();
    }
    if (request_.report_samples > 0)  // depths come afterwards
      store_->count_crossings(request_.max_distance ? kSampling.last : kMeasuringScan.last);
    store_->forget_triangles();
    if (report_.max_distance > 0 && request_.own_depths.value_or(true)) give_depths();
    if (!scan_.of_faces.empty())
      of_base_faces_ =
          scan_.of_faces.of_base_faces(scan_.surface, *scan_tree_, sampled_.surface, [&] {
            progress_.begin("face attributes", all_levels_ ? kCopyingLevels.first : kWriting.first);
          });
    make_store();
    return std::move(report_);
  }

 private:
  void check_request() const;
  void warn_of_fewer(std::string_view step, const Store& store, int threads) const {
    warn_of_fewer_threads(step, threads, request_.threads, store.options().budget_bytes,
                          watch_.warn);
  }
  void check_counts() const;
  void search();
  [[noreturn]] void refuse_distance(double found) const;
  void make_store();
  void write_store(const std::filesystem::path& path);
  void fill(Store& store, WorkPart writing, WorkPart writing_attributes);
  void give_depths();

  RemeshRequest request_;  ///< search() sets faces and levels
  const BackendRegistry& backends_;
  const JobWatch& watch_;
  ScanProgress progress_;
  RemeshReport report_;
  ScanToSample scan_;
  std::optional<TriangleTree> scan_tree_;
  std::optional<MeasuredStore> store_;
  std::vector<BaseFaceAttribute> of_base_faces_;
  BaseSamples sampled_;
  std::optional<Store> all_levels_;  ///< in memory, if the store has depths
  BaseMesh base_of_store_;           ///< with the depths
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
  for (std::size_t at = 0; at < scan_.attributes.count(); ++at)
    report_.attributes.push_back(scan_.attributes.schema(at));
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
  write_attributes(scan_.attributes, scan_.surface, sampled_.samples, surface, store,
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
        store_->set_triangles(drawn, to_store.first);
        store_->measure(to_store, to_scan, report_.max_distance);
        return std::max({report_.to_store.max, report_.to_scan.max, store_->farthest_vertex()});
      },
      report_);
}

void ScanRun::search() {
  const double limit = request_.max_distance->of(report_.diagonal);
  report_.max_distance = limit;
  DistanceSearch search(scan_.surface.faces.size(), request_.faces, request_.levels);
  // How many trials it will be is not known. Each takes half of the work that is left.
  for (WorkPart left = kSampling;; left = left.nth(1, 2)) {
    const WorkPart now = left.nth(0, 2);
    request_.faces = search.faces();
    request_.levels = search.levels();
    check_counts();
    check_memory_for(request_, scan_.surface.faces.size());
    ++report_.trials;
    report_.base_meshes = 0;
    sampled_ = make_base_samples(request_, scan_.surface, *scan_tree_, now.of(kTrialSampling),
                                 progress_, report_);
    store_->set_triangles(small_triangles(sampled_.surface), now.of(kTrialStore).first);
    store_->measure(now.of(kTrialStore), now.of(kTrialScan), limit);
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
