#include "collapse/decimate.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <numeric>
#include <span>
#include <thread>
#include <utility>

#include "base/threads.h"
#include "collapse/collapser.h"
#include "collapse/tiles.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr double kPointShare = 1e-3;  ///< of a vertex's area: keeps its quadric positive definite
constexpr double kBorderShare = 1;  ///< weight of a border's plane, in squared lengths of its edge

/// A part of the work: until this number of times the faces asked for are left.
struct Stage {
  double surplus;
  ShapeLimits limits;
};
constexpr double kTileSurplus = 10, kMiddleSurplus = 3.1623;  // the middle of 10 and 1, as a factor
constexpr ShapeLimits kFirm{0.2, 0.5, 0.5}, kLoose{0.1, 0.2, 0.2}, kLast{0.02, 0.0, 0.0},
    kRough{0.002, -0.5, -0.5}, kAny{0, -1, -1};
/// With the first limits alone, thin parts lock: of the last edges, nine of ten may not collapse,
/// so the last collapses take what is left, not what is cheapest. Faces there stay small, and
/// others become too large. A stage tries again what stages before it refused. The last two are for
/// scans whose own faces are needles or turn by more than the limits: only the plane that a
/// collapse is laid out in limits it then.
constexpr std::array<Stage, 6> kStages = {{{kTileSurplus, kFirm},
                                           {kMiddleSurplus, kLoose},
                                           {1, kLoose},
                                           {1, kLast},
                                           {1, kRough},
                                           {1, kAny}}};
constexpr std::array<Stage, 5> kFirmStages = {
    {{1, kFirm}, {1, kLoose}, {1, kLast}, {1, kRough}, {1, kAny}}};
/// A scan that is rough everywhere has no use for limits of shape: they would refuse cheap
/// collapses nearly everywhere, and dear ones would go on where the surface is smooth by chance,
/// until a limb is gone.
constexpr std::array<Stage, 2> kRoughStages = {{{kTileSurplus, kAny}, {1, kAny}}};
/// Of the edges that are no creases: more turn further than kFirm lets a face turn. Scans of things
/// have up to 0.02, noise of a fifth of an edge 0.07.
constexpr double kRoughShare = 0.05;
/// Tiles do the first stage, so that it is the last part of the work, over the whole surface, that
/// decides where faces are. Each tile keeps the same share of its faces.

constexpr FaceId kFacesBetweenTells = 1 << 16;

class Decimator {
 public:
  Decimator(const Surface& scan, const DecimateOptions& options)
      : state_(scan, options.creases != nullptr ? *options.creases : Creases{}),
        options_(options),
        first_faces_(scan.faces.size()) {
    normalise(scan);
    add_quadrics();
    is_rough_ = rough_share() > kRoughShare;
  }

  void run() {
    collapse_in_tiles();
    std::vector<FaceId> faces(first_faces_);
    std::iota(faces.begin(), faces.end(), FaceId{0});
    Collapser collapser(state_, Collapser::kWhole);
    const auto tell = [&] { tell_gone(first_faces_ - state_.mesh.live_faces()); };
    for (const Stage& stage : stages()) {
      const std::uint64_t goal = faces_of(stage);
      std::uint64_t before = 0;
      do {
        before = state_.mesh.live_faces();
        if (before <= goal) break;
        std::erase_if(faces, [&](FaceId face) { return !state_.mesh.lives(face); });
        collapser.collapse(faces, stage.limits, before - goal, tell);
      } while (before - state_.mesh.live_faces() > before / 100);
    }
    if (state_.mesh.live_faces() > options_.faces + 1)
      limits_ = collapser.refusals(faces, kStages.back().limits, tell);
  }

  Decimated finish();

 private:
  void normalise(const Surface& scan);
  void add_quadrics();
  double rough_share() const;
  /// The first one is also that of tiles.
  std::span<const Stage> stages() const {
    if (options_.firm) return kFirmStages;
    return is_rough_ ? std::span<const Stage>(kRoughStages) : kStages;
  }
  void collapse_in_tiles();
  std::uint64_t faces_of(const Stage& stage) const {
    return static_cast<std::uint64_t>(stage.surplus * static_cast<double>(options_.faces));
  }
  void tell_gone(std::uint64_t gone) const;

  CollapseState state_;
  DecimateOptions options_;
  std::uint64_t first_faces_;
  CollapseRefusals limits_;
  Point middle_{};
  double diagonal_ = 1;
  bool is_rough_ = false;
};

void Decimator::normalise(const Surface& scan) {
  Point low = scan.positions.empty() ? Point{} : scan.positions[0], high = low;
  for (const Point& p : scan.positions)
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], p[axis]);
      high[axis] = std::max(high[axis], p[axis]);
    }
  middle_ = 0.5 * (low + high);
  diagonal_ = length(high - low);
  if (!(diagonal_ > 0)) diagonal_ = 1;
  state_.positions.reserve(scan.positions.size());
  for (const Point& p : scan.positions) state_.positions.push_back((1 / diagonal_) * (p - middle_));
}

void Decimator::add_quadrics() {
  const CollapsingMesh& mesh = state_.mesh;
  const std::vector<Point>& positions = state_.positions;
  std::vector<Quadric>& quadrics = state_.quadrics;
  for (FaceId face = 0; face < first_faces_; ++face) {
    if (face % kFacesBetweenTells == 0) tell_gone(0);
    const auto& corners = mesh.faces()[face];
    const Point a = positions[corners[0]], b = positions[corners[1]], c = positions[corners[2]];
    const Point normal = area_vector(a, b, c);
    const double area = length(normal) / 2;
    state_.carried[face] = static_cast<float>(area);
    Quadric plane;
    plane.add_plane(normalized(normal), a, area / 3);
    for (const VertexId vertex : corners) {
      quadrics[vertex] = quadrics[vertex] + plane;
      quadrics[vertex].add_point(positions[vertex], kPointShare * area / 3);
    }
    for (int side = 0; side < 3; ++side) {
      const FaceSide edge(face, side);
      if (mesh.across(edge).exists() && !mesh.is_crease(edge)) continue;
      const VertexId start = mesh.start(edge), end = mesh.end(edge);
      const Point along = positions[end] - positions[start];
      Quadric wall;
      wall.add_plane(normalized(cross(along, normal)), positions[start],
                     kBorderShare * squared_length(along));
      quadrics[start] = quadrics[start] + wall;
      quadrics[end] = quadrics[end] + wall;
    }
  }
  for (std::size_t vertex = 0; vertex < options_.weights.size(); ++vertex)
    quadrics[vertex].scale(double{options_.weights[vertex]});
}

double Decimator::rough_share() const {
  const CollapsingMesh& mesh = state_.mesh;
  const auto normal_of = [&](FaceId face) {
    const auto& [a, b, c] = mesh.faces()[face];
    return area_vector(state_.positions[a], state_.positions[b], state_.positions[c]);
  };
  std::uint64_t edges = 0, rough = 0;
  for (FaceId face = 0; face < first_faces_; ++face) {
    if (face % kFacesBetweenTells == 0) tell_gone(0);
    const Point normal = normal_of(face);
    for (int side = 0; side < 3; ++side) {
      const FaceSide edge(face, side), beyond = mesh.across(edge);
      if (!beyond.exists() || beyond.code < edge.code || mesh.is_crease(edge)) continue;
      const Point other = normal_of(beyond.face());
      ++edges;
      rough += dot(normal, other) < kFirm.least_turn * length(normal) * length(other) ? 1u : 0u;
    }
  }
  return edges == 0 ? 0 : static_cast<double>(rough) / static_cast<double>(edges);
}

void Decimator::collapse_in_tiles() {
  const Stage& stage = stages().front();
  // Also where all limits are firm.
  const auto keep = static_cast<std::uint64_t>(kTileSurplus * static_cast<double>(options_.faces));
  if (keep >= first_faces_ / 2) return;
  const std::vector<std::vector<FaceId>> tiles =
      face_tiles(state_.positions, state_.mesh.faces(), options_.tile_faces);
  if (tiles.size() < 2) return;
  state_.tiles = vertex_tiles(state_.positions.size(), state_.mesh.faces(), tiles);
  std::atomic<std::uint64_t> gone{0};
  const auto tell = [&, caller = std::this_thread::get_id()] {
    if (std::this_thread::get_id() == caller) tell_gone(gone);
  };
  const auto collapse = [&](std::size_t tile) {
    const std::vector<FaceId>& faces = tiles[tile];
    const auto kept =
        static_cast<std::uint64_t>(static_cast<double>(faces.size()) * static_cast<double>(keep) /
                                   static_cast<double>(first_faces_));
    gone += Collapser(state_, static_cast<std::uint32_t>(tile))
                .collapse(faces, stage.limits, faces.size() - kept, tell);
  };
  each_on_workers(std::size_t{0}, tiles.size(), collapse);
  state_.tiles = {};
}

void Decimator::tell_gone(std::uint64_t gone) const {
  if (options_.progress &&
      !options_.progress(
          {"base mesh", gone, first_faces_ - std::min(first_faces_, options_.faces)}))
    throw Error(ErrorCode::kCancelled, "remesh: cancelled, base mesh");
}

Decimated Decimator::finish() {
  Decimated result;
  result.limits = {limits_.by_topology, limits_.by_shape};
  const CollapsingMesh& mesh = state_.mesh;
  std::vector<VertexId> number(state_.positions.size(), kNoId);
  for (FaceId face = 0; face < first_faces_; ++face) {
    if (!mesh.lives(face)) continue;
    for (const VertexId vertex : mesh.faces()[face]) number[vertex] = 0;
  }
  for (VertexId vertex = 0; vertex < number.size(); ++vertex) {
    if (number[vertex] == kNoId) continue;
    number[vertex] = static_cast<VertexId>(result.positions.size());
    result.positions.push_back(diagonal_ * state_.positions[vertex] + middle_);
  }
  for (FaceId face = 0; face < first_faces_; ++face) {
    if (!mesh.lives(face)) continue;
    const auto& [a, b, c] = mesh.faces()[face];
    result.faces.push_back({number[a], number[b], number[c]});
    result.scan_faces.push_back(face);
    if (options_.creases != nullptr && !options_.creases->sides.empty())
      for (int side = 0; side < 3; ++side)
        result.crease_sides.push_back(mesh.is_crease(FaceSide(face, side)) ? 1 : 0);
  }
  result.history = std::move(state_.history);
  return result;
}

}  // namespace

Decimated decimate(const Surface& scan, const DecimateOptions& options) {
  Decimator decimator(scan, options);
  decimator.run();
  return decimator.finish();
}

PLAIT_END_NAMESPACE
