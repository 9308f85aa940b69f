#include "generate/reduce.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "generate/random.h"
#include "generate/surface_editor.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace generation {
namespace {

using Side = SurfaceEditor::Side;

class Reducer {
 public:
  Reducer(IndexedMesh mesh, const ReduceOptions& options, const Progress& progress)
      : surface_(std::move(mesh)),
        options_(options),
        progress_(progress),
        initial_count_(surface_.live_vertex_count()) {}

  IndexedMesh run() && {
    // A collapse that was refused may become possible when the surface nearby has changed, so there
    // are several rounds. When no collapse keeps the shape of the triangles, the last rounds allow
    // others.
    while (!done() && round(true)) {
    }
    while (!done() && round(false)) {
    }
    return std::move(surface_).take();
  }

 private:
  struct QueuedSide {
    float key;
    Side side;
    /// The heap's top is its largest entry, so a short edge is the largest. The side makes the
    /// order total.
    bool operator<(const QueuedSide& other) const {
      return key > other.key || (key == other.key && side > other.side);
    }
  };

  bool done() const { return surface_.live_vertex_count() <= options_.vertices; }

  float key_of(Side side) const {
    const VertexId a = surface_.start(side), b = surface_.end(side);
    const Vector3<double> along = surface_.position(b) - surface_.position(a);
    double key = dot(along, along);
    if (options_.randomness > 0) {
      const auto [lower, higher] = std::minmax(a, b);
      const std::uint64_t edge = (std::uint64_t{lower} << 32) | higher;
      key *= 1 + options_.randomness * to_unit(mix(mix(edge) ^ options_.seed));
    }
    return static_cast<float>(key);
  }

  void push(Side side) {
    const Side beyond = surface_.beyond(side);
    const Side one = beyond != kNoId ? std::min(side, beyond) : side;
    queue_.push_back({key_of(one), one});
    std::push_heap(queue_.begin(), queue_.end());
  }

  /// Tries all edges once, and edges that change meanwhile again.
  bool round(bool keep_shape) {
    const std::uint64_t count_before = surface_.live_vertex_count();
    queue_.clear();
    for (Side side = 0; side < surface_.side_limit(); ++side)
      if (surface_.is_live(side) && (surface_.is_border(side) || side < surface_.beyond(side)))
        queue_.push_back({key_of(side), side});
    std::make_heap(queue_.begin(), queue_.end());
    while (!done() && !queue_.empty()) {
      std::pop_heap(queue_.begin(), queue_.end());
      const QueuedSide entry = queue_.back();
      queue_.pop_back();
      // If the edge has changed since, the queue has a newer entry for it.
      if (!surface_.is_live(entry.side) || key_of(entry.side) != entry.key) continue;
      try_collapse(entry.side, keep_shape);
    }
    return surface_.live_vertex_count() < count_before;
  }

  void try_collapse(Side side, bool keep_shape) {
    const VertexId kept = surface_.start(side);
    const Vector3<double> place = merged_position(side);
    if (keep_shape && !keeps_shape(side, place)) return;
    if (!surface_.can_collapse(side)) return;
    surface_.collapse(side, place);
    surface_.for_each_link_side(kept, [&](Side link) {
      push(SurfaceEditor::next(link));
      if (surface_.is_border(SurfaceEditor::previous(link))) push(SurfaceEditor::previous(link));
    });
    constexpr std::uint64_t kReportEvery = 4096;
    if (++collapse_count_ % kReportEvery == 0)
      progress_(static_cast<double>(collapse_count_) /
                static_cast<double>(initial_count_ - options_.vertices));
  }

  /// The middle of the edge, or its end on the border if exactly one end is there.
  Vector3<double> merged_position(Side side) const {
    const Vector3<double> a = surface_.position(surface_.start(side));
    const Vector3<double> b = surface_.position(surface_.end(side));
    const bool a_stays = surface_.is_on_border(surface_.start(side));
    const bool b_stays = surface_.is_on_border(surface_.end(side));
    if (a_stays != b_stays) return a_stays ? a : b;
    return 0.5 * (a + b);
  }

  bool keeps_shape(Side side, Vector3<double> place) const {
    constexpr int kHighestValence = 10, kLowestValence = 4;
    const VertexId a = surface_.start(side), b = surface_.end(side);
    const int lost = surface_.is_border(side) ? 3 : 4;
    if (surface_.valence(a) + surface_.valence(b) - lost > kHighestValence) return false;
    for (const Side half : {side, surface_.beyond(side)}) {
      if (half == kNoId) continue;
      const VertexId apex = surface_.apex(half);
      if (surface_.valence(apex) <= kLowestValence && !surface_.is_on_border(apex)) return false;
    }
    return keeps_normals(a, b, place) && keeps_normals(b, a, place);
  }

  /// Whether the faces around `moved` that do not contain `partner` turn by less than 60 degrees.
  bool keeps_normals(VertexId moved, VertexId partner, Vector3<double> place) const {
    constexpr double kLeastCosine = 0.5;
    bool kept = true;
    surface_.for_each_link_side(moved, [&](Side link) {
      if (!kept || surface_.start(link) == partner || surface_.end(link) == partner) return;
      const Vector3<double> p = surface_.position(surface_.start(link));
      const Vector3<double> along = surface_.position(surface_.end(link)) - p;
      const Vector3<double> before = cross(along, surface_.position(moved) - p);
      const Vector3<double> after = cross(along, place - p);
      const double product = dot(before, after);
      kept = product > 0 && product * product > kLeastCosine * kLeastCosine * dot(before, before) *
                                                    dot(after, after);
    });
    return kept;
  }

  SurfaceEditor surface_;
  ReduceOptions options_;
  Progress progress_;
  std::uint64_t initial_count_;
  std::uint64_t collapse_count_ = 0;
  std::vector<QueuedSide> queue_;
};

}  // namespace

IndexedMesh reduce(IndexedMesh mesh, const ReduceOptions& options, const Progress& progress) {
  return Reducer(std::move(mesh), options, progress).run();
}

}  // namespace generation
PLAIT_END_NAMESPACE
