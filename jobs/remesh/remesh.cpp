#include "remesh/remesh.h"

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/byte_text.h"
#include "base/stopwatch.h"
#include "collapse/decimate.h"
#include "import/fine_mesh.h"
#include "io/machine.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/extend/attributed_mesh.h"
#include "plait/layout.h"
#include "plait/store.h"
#include "remesh/sampled_surface.h"
#include "remesh/scan_attributes.h"
#include "sample/relax.h"
#include "sample/samples.h"
#include "sample/untangle.h"
#include "store/left_overs.h"
#include "store/partial_store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::uint64_t kBytesPerScanFace = 200;
constexpr std::uint64_t kBytesPerSmallFace = 140;
constexpr std::uint64_t kFacesPerVertex = 2;
constexpr std::string_view kTurned = "turned", kDistance = "distance";
/// relax() numbers the corners of small faces in 32 bits.
constexpr std::uint64_t kMostSmallFaces = (std::uint64_t{1} << 32) / 3;

/// Parts of the whole work, in thousandths.
struct WorkPart {
  std::uint64_t first, last;
};
constexpr WorkPart kDecimating = {0, 550}, kSampling = {550, 600}, kRelaxing = {600, 700},
                   kWriting = {700, 760}, kWritingAttributes = {760, 800},
                   kMeasuringStore = {800, 900}, kMeasuringScan = {900, 1000};

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
  ScanRun(const RemeshRequest& request, const BackendRegistry& backends, const RemeshWatch& watch)
      : request_(request), backends_(backends), watch_(watch) {}

  RemeshReport run() {
    check_request();
    read_scan();
    make_base();
    make_samples();
    make_store();
    return std::move(report_);
  }

 private:
  void check_request() const;
  void check_memory(std::uint64_t scan_faces) const;
  void read_scan();
  void make_base();
  void make_samples();
  void mark_turned();
  void make_store();
  void write_store(const std::filesystem::path& path);
  void measure();
  BaseShape shape_of(const BaseMesh& base) const;

  ProgressCallback progress_of(WorkPart part) const {
    if (!watch_.progress) return {};
    return [this, part](const Progress& now) {
      const std::uint64_t done =
          now.total == 0 ? 0 : (part.last - part.first) * std::min(now.done, now.total) / now.total;
      return watch_.progress({now.phase, part.first + done, 1000});
    };
  }
  void tell(std::string_view phase, WorkPart part) const {
    if (watch_.progress && !watch_.progress({phase, part.first, 1000}))
      throw Error(ErrorCode::kCancelled, fmt::format("remesh: cancelled, {}", phase));
  }

  const RemeshRequest& request_;
  const BackendRegistry& backends_;
  const RemeshWatch& watch_;
  RemeshReport report_;
  Surface scan_;
  ScanAttributes attributes_;
  std::vector<FaceId> history_faces_;  ///< [face of the base mesh] its number in the history
  CollapseHistory history_{0};
  SampledSurface sampled_;
  std::vector<SurfacePoint> samples_;
};

void ScanRun::check_request() const {
  if (request_.faces < 1)
    throw Error(ErrorCode::kInvalidArgument, "remesh: faces: expected 1 or more, found 0");
  if (request_.levels < 1 || request_.levels > 12)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("remesh: levels: expected 1 to 12, found {}", request_.levels));
  if (request_.faces > kMostSmallFaces >> (2 * request_.levels))
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("remesh: expected at most {} faces of the base mesh at level {}, found "
                    "{}",
                    kMostSmallFaces >> (2 * request_.levels), request_.levels, request_.faces));
  PartialStore::check(request_.store, request_.replace ? Existing::kReplace : Existing::kRefuse);
}

void ScanRun::check_memory(std::uint64_t scan_faces) const {
  const std::uint64_t base_faces = std::min(request_.faces, scan_faces);
  const std::uint64_t needed = scan_faces * kBytesPerScanFace +
                               (base_faces << (2 * request_.levels)) * kBytesPerSmallFace +
                               request_.options.budget_bytes;
  const std::uint64_t found = available_memory_bytes();
  if (request_.ignore_size || needed <= found) return;
  throw Error(ErrorCode::kOutOfMemory,
              fmt::format("remesh {}: expected {} of memory for {} faces and {} small faces, found "
                          "{}",
                          request_.scan.native(), format_bytes(needed), scan_faces,
                          base_faces << (2 * request_.levels), format_bytes(found)));
}

void ScanRun::read_scan() {
  Stopwatch clock;
  tell("read", kDecimating);
  check_memory(kFacesPerVertex * expected_vertices(request_.scan));
  std::vector<std::string> warnings;
  AttributedMesh mesh = read_attributed_mesh(request_.scan, &warnings, NotFinite::kKeep);
  leave_out_own_names(mesh.attributes, request_.distances, warnings);
  if (watch_.warn)
    for (const std::string& warning : warnings) watch_.warn(warning);
  report_.read_seconds = clock.lap();
  check_memory(mesh.mesh.faces.size());
  tell("repair", kDecimating);
  Repaired repaired = repair(std::move(mesh.mesh), request_.repair, request_.scan.native());
  attributes_ = ScanAttributes(std::move(mesh.attributes), repaired);
  scan_ = std::move(repaired.surface);
  report_.repairs = repaired.list;
  report_.scan = figures_of(scan_);
  const TriangleSet triangles{scan_.positions, scan_.faces};
  report_.diagonal = diagonal_of(triangles);
  report_.mean_edge = mean_edge_of(triangles);
  report_.repair_seconds = clock.lap();
}

void ScanRun::make_base() {
  const Stopwatch clock;
  Decimated decimated =
      decimate(scan_, {.faces = request_.faces, .progress = progress_of(kDecimating)});
  report_.kept_by_topology = decimated.limits.by_topology;
  report_.kept_by_shape = decimated.limits.by_shape;
  history_ = std::move(decimated.history);

  // The base vertices are points of the scan, too. Faces keep their corners, so a corner is
  // followed back from any face that has it.
  for (FaceId face = 0; face < decimated.faces.size(); ++face)
    for (std::size_t corner = 0; corner < 3; ++corner) {
      SurfacePoint point{decimated.scan_faces[face], {}};
      point.weights[corner] = 1;
      decimated.positions[decimated.faces[face][corner]] =
          position_of(scan_, history_.follow_back(point));
    }
  const BaseMesh base = BaseMesh::build({decimated.positions, decimated.faces}, "base mesh");
  const std::vector<FaceId> order = face_order(base, LayoutKind::kHilbert);
  sampled_.base = base.with_face_order(order);
  sampled_.levels = request_.levels;
  for (const FaceId face : order) history_faces_.push_back(decimated.scan_faces[face]);
  report_.base = figures_of(
      repair({std::move(decimated.positions), std::move(decimated.faces)}, {}, "base mesh")
          .surface);
  report_.shape = shape_of(sampled_.base);
  report_.decimate_seconds = clock.seconds();
}

BaseShape ScanRun::shape_of(const BaseMesh& base) const {
  std::vector<double> qualities;
  std::vector<std::uint64_t> valences(base.vertex_count(), 0);
  for (const auto& [a, b, c] : base.faces()) {
    const Point p = base.positions()[a], q = base.positions()[b], r = base.positions()[c];
    qualities.push_back(
        triangle_quality(length(area_vector(p, q, r)),
                         squared_length(q - p) + squared_length(r - q) + squared_length(p - r)));
  }
  for (const Edge& edge : base.edges()) {
    ++valences[edge.start];
    ++valences[edge.end];
  }
  std::sort(qualities.begin(), qualities.end());
  return {qualities.front(), qualities[qualities.size() / 100], qualities[qualities.size() / 2],
          *std::max_element(valences.begin(), valences.end())};
}

void ScanRun::make_samples() {
  Stopwatch clock;
  samples_ =
      sample_scan(history_, sampled_.base, history_faces_, request_.levels, progress_of(kSampling));
  history_ = CollapseHistory(0);
  report_.vertices = samples_.size();
  report_.small_faces = sampled_.base.face_count() << (2 * request_.levels);
  report_.sample_seconds = clock.lap();
  report_.relaxed_samples =
      relax(scan_, sampled_.base, request_.levels, {.progress = progress_of(kRelaxing)}, samples_);
  report_.relax_seconds = clock.lap();
  tell("untangle", kWriting);
  const Untangled untangled = untangle(scan_, sampled_.base, request_.levels, {}, samples_);
  report_.turned_before = untangled.before;
  report_.turned = untangled.after;
  report_.moved_samples = untangled.moved;
  if (untangled.after > 0 && request_.refuse_turned)
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("remesh {}: expected no small triangle that is turned over, found {} of "
                    "{}: take more faces",
                    request_.scan.native(), untangled.after, report_.small_faces));
  if (untangled.after > 0) mark_turned();
  sampled_.positions.reserve(samples_.size());
  for (const SurfacePoint& sample : samples_) {
    const Point p = position_of(scan_, sample);
    const Vector3<float> narrow = {static_cast<float>(p.x), static_cast<float>(p.y),
                                   static_cast<float>(p.z)};
    if (!std::isfinite(narrow.x) || !std::isfinite(narrow.y) || !std::isfinite(narrow.z))
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("remesh {}: expected positions within float32, found ({}, {}, {})",
                              request_.scan.native(), p.x, p.y, p.z));
    sampled_.positions.push_back(narrow);
  }
  report_.untangle_seconds = clock.lap();
  if (request_.distances) {
    tell("distances", kWriting);
    sampled_.distances = distances_at_samples(scan_, sampled_);
  }
}

void ScanRun::mark_turned() {
  const SampleNumbers numbers(sampled_.base, request_.levels);
  sampled_.turned.assign(samples_.size(), 0);
  for (FaceId face = 0; face < sampled_.base.face_count(); ++face)
    numbers.for_each_triangle(face, [&](std::uint64_t a, std::uint64_t b, std::uint64_t c) {
      if (is_turned(scan_, samples_[a], samples_[b], samples_[c]))
        sampled_.turned[a] = sampled_.turned[b] = sampled_.turned[c] = 1;
    });
}

void ScanRun::make_store() {
  const Stopwatch clock;
  PartialStore output(request_.store, request_.replace ? Existing::kReplace : Existing::kRefuse);
  const auto warn = [&](const std::string& what) {
    if (watch_.warn) watch_.warn(what);
  };
  remove_left_overs_of(request_.store, warn);
  build_output(output, [&] { write_store(output.make()); });
  report_.write_seconds = clock.seconds();
  measure();
  tell("publish", {1000, 1000});
  output.publish(request_.options.durability == Durability::kCommit, warn);
}

void ScanRun::write_store(const std::filesystem::path& path) {
  StoreOptions options = request_.options;
  options.expected_bytes = sampled_.positions.size() * sizeof(Vector3<float>);
  Store store =
      Store::create(path, BaseMesh(sampled_.base), options, backends_, {.layout = "hilbert"});
  write_levels(sampled_, store, request_.threads, progress_of(kWriting));
  write_attributes(attributes_, scan_, samples_, sampled_, store, progress_of(kWritingAttributes));
  for (std::size_t at = 0; at < attributes_.count(); ++at)
    report_.attributes.push_back(attributes_.schema(at));
  store.commit();
  report_.backend = store.options().backend;
  report_.stored_bytes = store.stored_bytes();
  if (request_.digest) report_.digest = digest(store, {.threads = request_.threads}).to_string();
  store.close();
}

void ScanRun::measure() {
  const Stopwatch clock;
  if (request_.report_samples == 0) return;
  const IndexedMesh small = small_triangles(sampled_);
  const TriangleSet scan{scan_.positions, scan_.faces}, store{small.positions, small.faces};
  tell("distances", kMeasuringStore);
  report_.to_store = measure_distances(scan, TriangleTree(store.positions, store.faces), store,
                                       {.samples = request_.report_samples,
                                        .phase = "distance to the store",
                                        .progress = progress_of(kMeasuringStore)});
  report_.to_scan = measure_distances(store, TriangleTree(scan.positions, scan.faces), scan,
                                      {.samples = request_.report_samples,
                                       .phase = "distance to the scan",
                                       .progress = progress_of(kMeasuringScan)});
  report_.report_seconds = clock.seconds();
}

}  // namespace

RemeshReport remesh(const RemeshRequest& request, const BackendRegistry& backends,
                    const RemeshWatch& watch) {
  return with_memory_errors("remesh " + request.scan.native(), [&] {
    // TBB takes other numbers for one of its own choice.
    if (request.threads < 1)
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("remesh: threads: expected 1 or more, found {}", request.threads));
    RemeshReport report;
    tbb::task_arena(request.threads).execute([&] {
      report = ScanRun(request, backends, watch).run();
    });
    return report;
  });
}

PLAIT_END_NAMESPACE
