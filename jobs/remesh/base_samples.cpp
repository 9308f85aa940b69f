#include "remesh/base_samples.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

#include "base/stopwatch.h"
#include "collapse/decimate.h"
#include "mesh/narrowing.h"
#include "plait/error.h"
#include "plait/layout.h"
#include "remesh/base_numbers.h"
#include "remesh/rounded_positions.h"
#include "sample/area_spread.h"
#include "sample/exact_faces.h"
#include "sample/folds.h"
#include "sample/relax.h"
#include "sample/turned.h"
#include "sample/untangle.h"
#include "surface/creases.h"
#include "surface/repair.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Parts of the work on one base mesh, in thousandths.
constexpr WorkPart kDecimateStep = {0, 750}, kSampleStep = {750, 800},
                   kFirstUntangleStep = {800, 830}, kRelaxStep = {830, 970},
                   kLastUntangleStep = {970, 1000};

/// With refuse_turned, at most this number of base meshes are made. From the middle one on they are
/// firm (collapse/decimate.h), which suits fins.
constexpr std::uint64_t kMostBaseMeshes = 8, kFirstFirmMesh = 5;
/// The part of a scan where small triangles are turned over counts this number of times in the next
/// base mesh. Smaller factors need more base meshes, larger ones take more faces from other parts.
constexpr float kWeightOfTurned = 8;
/// A base mesh may have this number of times the faces asked for.
constexpr double kMostSurplus = 1.05;
/// The most places that an error names.
constexpr std::size_t kMostPlaces = 3;

BaseShape shape_of(const BaseMesh& base) {
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

class BaseSampler {
 public:
  BaseSampler(const RemeshRequest& request, const Surface& scan, const TriangleTree& tree,
              WorkPart part, const ScanProgress& progress, RemeshReport& report)
      : request_(request),
        scan_(scan),
        tree_(tree),
        part_(part),
        progress_(progress),
        report_(report) {
    set_creases(find_creases(scan, request.feature_angle));
  }

  BaseSamples run() {
    for (;;) {
      begin_base_mesh();
      make_base();
      make_samples();
      if (report_.turned == 0 || !request_.refuse_turned) break;
      if (report_.base_meshes == kMostBaseMeshes) refuse_turned();
      weigh_turned_faces(scan_, result_.surface.base, request_.levels, result_.samples,
                         has_creases(), kWeightOfTurned, weights_);
    }
    result_.surface.crease_sides.clear();
    for (std::size_t side = 0; side < crease_sides_.size(); side += 3)
      result_.surface.crease_sides.push_back(static_cast<std::uint8_t>(
          crease_sides_[side] | crease_sides_[side + 1] << 1 | crease_sides_[side + 2] << 2));
    const auto go_on = [&] { progress_.begin("positions", now_.last); };
    go_on();
    mark_turned();
    go_on();
    number_in_face_order(result_);
    go_on();
    set_positions();
    go_on();
    report_.folds = count_folds(result_.surface.base, request_.levels, result_.surface.positions);
    go_on();
    report_.area_spread =
        area_spread(result_.surface.base, request_.levels, result_.surface.positions);
    return std::move(result_);
  }

 private:
  void set_creases(Creases creases);
  void begin_base_mesh();
  void make_base();
  void make_samples();
  bool has_creases() const { return creases_.edge_count > 0; }
  bool is_reached(std::uint64_t faces) const {
    return request_.max_distance || faces <= request_.faces + 1 ||
           static_cast<double>(faces) <= kMostSurplus * static_cast<double>(request_.faces);
  }
  void check_reached(std::uint64_t faces) const;
  std::string remedy_for_needles() const;
  [[noreturn]] void refuse_turned() const;
  void mark_turned();
  void set_positions();
  ProgressCallback during(WorkPart step) const { return progress_.during(now_.of(step)); }

  const RemeshRequest& request_;
  const Surface& scan_;
  const TriangleTree& tree_;
  WorkPart part_;
  WorkPart now_{};  ///< of the present base mesh
  const ScanProgress& progress_;
  RemeshReport& report_;
  Creases creases_;
  Surface cut_;                             ///< at creases; empty if there are none
  std::vector<std::uint8_t> crease_sides_;  ///< [3 face of the base mesh + side]
  std::vector<float> weights_;         ///< [vertex of the scan] for decimate(), with refuse_turned
  std::vector<FaceId> history_faces_;  ///< [face of the base mesh] its number in the history
  CollapseHistory history_{0};
  BaseSamples result_;
};

void BaseSampler::set_creases(Creases creases) {
  creases_ = std::move(creases);
  report_.feature_angle = creases_.angle;
  report_.crease_edges = creases_.edge_count;
  report_.crease_corners = creases_.corner_count;
  cut_ = creases_.edge_count > 0 ? cut_at(scan_, creases_) : Surface{};
}

void BaseSampler::begin_base_mesh() {
  ++report_.base_meshes;
  now_ = part_;
  if (!request_.refuse_turned) return;
  if (report_.base_meshes == 1 || report_.base_meshes == kFirstFirmMesh)
    weights_.assign(scan_.positions.size(), 1);
  // How many base meshes it will be is not known. Each takes half of the work that is left.
  for (std::uint64_t before = 1; before < report_.base_meshes; ++before) now_ = now_.nth(1, 2);
  now_ = now_.nth(0, 2);
}

/// More base faces than asked for are more small faces, memory and bytes than the caller expects.
void BaseSampler::check_reached(std::uint64_t faces) const {
  if (is_reached(faces)) return;
  std::string remedy;
  if (report_.lost_step > 0) remedy += ", or a scan that has the lost digits of its coordinates";
  remedy += remedy_for_needles();
  if (report_.scan.components > 1)
    remedy += fmt::format(", or --min-component N removes small ones of its {} components",
                          report_.scan.components);
  if (report_.crease_edges > 0)
    remedy +=
        fmt::format(", or --feature-angle none lets its {} sharp edges go", report_.crease_edges);
  if (report_.scan.borders > 0)
    remedy +=
        fmt::format(", or --fill-holes N fills small ones of its {} borders", report_.scan.borders);
  throw Error(
      ErrorCode::kInvalidArgument,
      fmt::format("remesh {}: expected a base mesh of {} faces, found {} as the fewest: {} edges "
                  "are kept by genus, borders, components, sharp edges or vertices of many "
                  "faces, {} by the shape of faces: take --faces {} (fewer --levels make as many "
                  "small faces){}",
                  request_.scan.native(), request_.faces, faces, report_.kept_by_topology,
                  report_.kept_by_shape, faces, remedy));
}

/// Faces without area have no side that others could turn over to, and no shape to keep.
std::string BaseSampler::remedy_for_needles() const {
  const std::uint64_t count = report_.repairs.needle_faces;
  if (count == 0) return {};
  return fmt::format(", or --weld, with a tolerance or without: {} of its faces {} no area", count,
                     count == 1 ? "has" : "have");
}

void BaseSampler::make_base() {
  const Stopwatch clock;
  const auto decimated_scan = [&] {
    return decimate(scan_, {.faces = request_.faces,
                            .weights = weights_,
                            .firm = report_.base_meshes >= kFirstFirmMesh,
                            .creases = &creases_,
                            .progress = during(kDecimateStep)});
  };
  Decimated decimated = decimated_scan();
  if (!is_reached(decimated.faces.size()) && creases_.edge_count > 0 && !request_.feature_angle) {
    // Nobody asked for them.
    report_.faces_for_creases = decimated.faces.size();
    set_creases({});
    decimated = decimated_scan();
  }
  report_.kept_by_topology = decimated.limits.by_topology;
  report_.kept_by_shape = decimated.limits.by_shape;
  check_reached(decimated.faces.size());
  history_ = std::move(decimated.history);
  progress_.begin("base mesh", now_.of(kSampleStep).first);

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
  result_.surface.base = base.with_face_order(order);
  result_.surface.levels = request_.levels;
  history_faces_.clear();
  crease_sides_.clear();
  for (const FaceId face : order) {
    history_faces_.push_back(decimated.scan_faces[face]);
    if (decimated.crease_sides.empty()) continue;
    for (std::size_t side = 0; side < 3; ++side)
      crease_sides_.push_back(decimated.crease_sides[3 * face + side]);
  }
  report_.base = figures_of(
      repair({std::move(decimated.positions), std::move(decimated.faces)}, {}, "base mesh")
          .surface);
  report_.shape = shape_of(result_.surface.base);
  report_.decimate_seconds += clock.seconds();
}

void BaseSampler::make_samples() {
  Stopwatch clock;
  const BaseMesh& base = result_.surface.base;
  result_.samples =
      sample_scan(history_, base, history_faces_, request_.levels, during(kSampleStep));
  history_ = CollapseHistory(0);
  report_.vertices = result_.samples.size();
  report_.small_faces = base.face_count() << (2 * request_.levels);
  report_.from_vertices = report_.vertices;
  report_.from_faces = report_.small_faces;
  report_.sample_seconds += clock.lap();
  const Surface& cut = has_creases() ? cut_ : scan_;
  const std::vector<std::uint8_t> still = vertices_on_sides(base, request_.levels, crease_sides_);
  // relax() turns no triangle over, but leaves those that are: they are fewer if it begins without.
  const Untangled before = untangle(scan_, base, request_.levels,
                                    {.still_samples = still,
                                     .cut = has_creases() ? &cut_ : nullptr,
                                     .progress = during(kFirstUntangleStep)},
                                    result_.samples);
  report_.untangle_seconds += clock.lap();
  // What lies on the scan cannot come closer to it.
  const std::vector<std::uint8_t> exact =
      exact_faces(scan_, tree_, base, request_.levels, result_.samples,
                  [&] { progress_.begin("relax", now_.of(kRelaxStep).first); });
  report_.exact_faces = static_cast<std::uint64_t>(std::count(exact.begin(), exact.end(), 1));
  report_.relaxed_samples =
      relax(cut, base, request_.levels,
            {.still_faces = exact, .still_samples = still, .progress = during(kRelaxStep)},
            result_.samples);
  report_.relax_seconds += clock.lap();
  const Untangled untangled = untangle(scan_, base, request_.levels,
                                       {.still_samples = still,
                                        .cut = has_creases() ? &cut_ : nullptr,
                                        .progress = during(kLastUntangleStep)},
                                       result_.samples);
  report_.turned_before = before.before;
  report_.turned = untangled.after;
  report_.moved_samples = before.moved + untangled.moved;
  report_.untangle_seconds += clock.lap();
}

void BaseSampler::refuse_turned() const {
  std::string places;
  std::size_t count = 0;
  for_each_turned(scan_, result_.surface.base, request_.levels, result_.samples, has_creases(),
                  [&](FaceId, std::uint64_t a, std::uint64_t, std::uint64_t) {
                    if (++count > kMostPlaces) return;
                    const Point p = position_of(scan_, result_.samples[a]);
                    places += fmt::format("{}({:.6g}, {:.6g}, {:.6g})", count > 1 ? ", " : "", p.x,
                                          p.y, p.z);
                  });
  if (count > kMostPlaces) places += ", ...";
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("remesh {}: expected no small triangle that is turned over, found {} of "
                          "{} with the last of {} base meshes, at {}: take more faces{}",
                          request_.scan.native(), report_.turned, report_.small_faces,
                          report_.base_meshes, places, remedy_for_needles()));
}

void BaseSampler::mark_turned() {
  std::vector<std::uint8_t>& turned = result_.surface.turned;
  turned.assign(result_.samples.size(), 0);
  if (report_.turned == 0) return;
  for_each_turned(scan_, result_.surface.base, request_.levels, result_.samples, has_creases(),
                  [&](FaceId, std::uint64_t a, std::uint64_t b, std::uint64_t c) {
                    turned[a] = turned[b] = turned[c] = 1;
                  });
}

/// With the numbers that the store has: of float32, unless it gets float64, and rounded as the
/// request says. The base mesh gets those of its vertices.
void BaseSampler::set_positions() {
  const auto stored = [&](double number) {
    return report_.precision == ComponentType::kFloat64 ? number : as_float32(number);
  };
  result_.surface.positions.reserve(result_.samples.size());
  for (const SurfacePoint& sample : result_.samples) {
    const Point p = position_of(scan_, sample);
    const Point rounded = {stored(p.x), stored(p.y), stored(p.z)};
    if (!std::isfinite(rounded.x) || !std::isfinite(rounded.y) || !std::isfinite(rounded.z))
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("remesh {}: expected positions within {}, found ({}, {}, {})",
                              request_.scan.native(), to_string(report_.precision), p.x, p.y, p.z));
    result_.surface.positions.push_back(rounded);
  }
  if (request_.max_error)
    report_.rounding = round_positions(result_.surface, report_.precision, *request_.max_error);
  give_base_positions(result_.surface);
}

}  // namespace

BaseSamples make_base_samples(const RemeshRequest& request, const Surface& scan,
                              const TriangleTree& tree, WorkPart part, const ScanProgress& progress,
                              RemeshReport& report) {
  return BaseSampler(request, scan, tree, part, progress, report).run();
}

PLAIT_END_NAMESPACE
