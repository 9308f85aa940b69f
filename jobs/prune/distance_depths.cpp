#include "prune/distance_depths.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <span>
#include <utility>

#include "conversion/read_back.h"
#include "distance/distances.h"
#include "plait/error.h"
#include "plait/reader.h"
#include "prune/balance.h"
#include "prune/patch_distance.h"
#include "store/base_positions.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The depths while they are looked for.
template <class Real>
class DepthSearch {
 public:
  DepthSearch(const Store& store, double tolerance, int balance, const JobWatch& watch)
      : reader_(store, {.attributes = {"position"}, .policy = EvictionPolicy::kLayoutOrder}),
        mesh_(store.base().topology()),
        finest_level_(store.attributes()[store.attribute("position")].finest_level),
        levels_(finest_level_ - store.base_level()),
        balance_(balance),
        patch_(levels_, tolerance),
        progress_(begin_step(watch, "distances")),
        depths_(mesh_.faces.size()),
        distances_(mesh_.faces.size()) {}

  /// The smallest tolerance for which at most `most` vertices are left.
  DistanceDepths run(std::uint64_t most, const BaseMesh& base) {
    std::vector<float> errors;  // [face * levels + depth]
    errors.reserve(depths_.size() * static_cast<std::size_t>(levels_));
    std::vector<bool> wanted(mesh_.faces.size(), true);
    for_each(wanted, [&](FaceId) {
      for (int depth = 0; depth < levels_; ++depth)
        errors.push_back(static_cast<float>(patch_.distance({depth, {depth, depth, depth}})));
      return std::uint8_t{0};
    });
    std::vector<float> tolerances = errors;
    std::ranges::sort(tolerances);
    tolerances.erase(std::unique(tolerances.begin(), tolerances.end()), tolerances.end());
    DistanceDepths result;
    const auto is_small = [&](float tolerance) {
      for (FaceId face = 0; face < depths_.size(); ++face)
        depths_[face] =
            depth_within(std::span(errors).subspan(face * static_cast<std::size_t>(levels_),
                                                   static_cast<std::size_t>(levels_)),
                         tolerance);
      result.raised = balance_depths(mesh_, balance_, depths_);
      return counts_at_level(base.with_depths(depths_), levels_).vertices <= most;
    };
    if (!is_small(-1)) {  // else all levels are
      const auto found =
          std::ranges::partition_point(tolerances, [&](float each) { return !is_small(each); });
      is_small(found == tolerances.end() ? std::numeric_limits<float>::infinity() : *found);
    }
    // As it is drawn, with the sides of the neighbours.
    for (FaceId face = 0; face < depths_.size(); ++face) wanted[face] = depths_[face] < levels_;
    for_each(wanted, [&](FaceId face) {
      result.distance = std::max(result.distance, patch_.distance(drawn(face, depths_)));
      return depths_[face];
    });
    result.depths = std::move(depths_);
    return result;
  }

  DistanceDepths run() {
    std::vector<bool> wanted(mesh_.faces.size(), true);
    for_each(wanted, [&](FaceId face) { return first_depth(face); });
    DistanceDepths result;
    std::vector<std::uint8_t> before = depths_;
    result.raised = balance_depths(mesh_, balance_, depths_);
    for (bool is_first = true;; is_first = false) {
      bool any = false;
      for (FaceId face = 0; face < depths_.size(); ++face)
        any |= wanted[face] = is_unknown(face, before, is_first);
      if (!any) break;
      before = depths_;
      for_each(wanted, [&](FaceId face) { return deeper_if_far(face, before); });
      result.raised += balance_depths(mesh_, balance_, depths_);
    }
    for (FaceId face = 0; face < depths_.size(); ++face)
      if (depths_[face] < levels_) result.distance = std::max(result.distance, distances_[face]);
    result.depths = std::move(depths_);
    return result;
  }

 private:
  template <class Work>
  void for_each(const std::vector<bool>& wanted, Work work) {
    const auto total = static_cast<std::uint64_t>(std::ranges::count(wanted, true));
    std::uint64_t done = 0;
    for (FaceId face = 0; face < wanted.size(); ++face) {
      if (!wanted[face]) continue;
      read(face);
      depths_[face] = work(face);
      if (progress_ && !progress_({"distances", ++done, total}))
        throw Error(ErrorCode::kCancelled, "prune: cancelled");
    }
  }
  void read(FaceId face) {
    const PatchView view = reader_.read_patch(face, finest_level_);
    const auto positions = view.attribute<Vector3<Real>>("position");
    patch_.fill([&](std::int64_t i, std::int64_t j) {
      const Vector3<Real>& at = positions.at(i, j);
      return Vector3<double>{double{at.x}, double{at.y}, double{at.z}};
    });
  }

  static std::uint8_t depth_within(std::span<const float> errors, float tolerance) {
    const auto near = std::ranges::find_if(errors, [&](float error) { return error <= tolerance; });
    return static_cast<std::uint8_t>(near - errors.begin());
  }

  std::uint8_t first_depth(FaceId face) {
    for (int depth = 0; depth < levels_; ++depth) {
      distances_[face] = patch_.distance({depth, {depth, depth, depth}});
      if (patch_.is_near(distances_[face])) return static_cast<std::uint8_t>(depth);
    }
    distances_[face] = 0;
    return static_cast<std::uint8_t>(levels_);
  }

  /// As a face is drawn with these depths.
  DrawnDepths drawn(FaceId face, const std::vector<std::uint8_t>& depths) const {
    return drawn_depths(mesh_, face, [&](FaceId each) { return depths[each]; });
  }
  /// Whether the face is drawn otherwise than when its distance was found. `before`: depths then;
  /// `had_plain_sides`: sides were as coarse as their faces.
  bool is_unknown(FaceId face, const std::vector<std::uint8_t>& before,
                  bool had_plain_sides) const {
    const DrawnDepths now = drawn(face, depths_);
    if (now.face == levels_) return false;
    if (had_plain_sides) return now.face != before[face] || !now.is_plain();
    const DrawnDepths then = drawn(face, before);
    return now.face != then.face || now.sides != then.sides;
  }

  std::uint8_t deeper_if_far(FaceId face, const std::vector<std::uint8_t>& depths) {
    distances_[face] = patch_.distance(drawn(face, depths));
    if (patch_.is_near(distances_[face])) return depths[face];
    distances_[face] = 0;  // it is drawn otherwise from now on
    return static_cast<std::uint8_t>(depths[face] + 1);
  }

  const Reader reader_;
  const Topology mesh_;
  int finest_level_, levels_, balance_;
  PatchDistance patch_;
  const ProgressCallback progress_;
  std::vector<std::uint8_t> depths_;
  std::vector<double> distances_;
};

/// `run` gets a DepthSearch.
template <class Run>
DistanceDepths search(const Store& store, double tolerance, int balance, const JobWatch& watch,
                      Run run) {
  const auto& [schema, finest] = store.attributes()[position_of(store, "prune")];
  const std::uint64_t patch_bytes =
      sizeof(Vector3<double>) *
      patch_vertex_count(std::int64_t{1} << (finest - store.base_level()));
  if (patch_bytes > store.options().budget_bytes / 2)
    throw Error(
        ErrorCode::kBudget,
        fmt::format("prune {}: a patch of level {} has {} bytes, expected at most half of "
                    "the budget of {}: raise --memory",
                    store.path().native(), finest, patch_bytes, store.options().budget_bytes));
  return schema.type == ComponentType::kFloat32
             ? run(DepthSearch<float>(store, tolerance, balance, watch))
             : run(DepthSearch<double>(store, tolerance, balance, watch));
}

}  // namespace

DistanceDepths depths_by_distance(const Store& store, const RelativeLength& wanted, int balance,
                                  const JobWatch& watch) {
  const double tolerance =
      wanted.of(diagonal_of(TriangleSet{store.base().positions(), store.base().faces()}));
  DistanceDepths result =
      search(store, tolerance, balance, watch, [](auto&& depths) { return depths.run(); });
  result.tolerance = tolerance;
  return result;
}

DistanceDepths depths_by_vertices(const Store& store, std::uint64_t most, int balance,
                                  const JobWatch& watch) {
  if (most < store.base().vertex_count())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("prune {} to {} vertices: expected at least {}, those of the base mesh",
                            store.path().native(), most, store.base().vertex_count()));
  return search(store, std::numeric_limits<double>::infinity(), balance, watch,
                [&](auto&& depths) { return depths.run(most, store.base()); });
}

PLAIT_END_NAMESPACE
