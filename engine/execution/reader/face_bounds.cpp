#include "execution/reader/face_bounds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "plait/detail/face_depths.h"
#include "plait/error.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/vector3.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The float32 that is nearest to `value` and not on its other side.
float rounded_down(float value) { return value; }
float rounded_up(float value) { return value; }
float rounded_down(double value) {
  const auto nearest = static_cast<float>(value);
  return nearest > value ? std::nextafter(nearest, -std::numeric_limits<float>::infinity())
                         : nearest;
}
float rounded_up(double value) { return -rounded_down(-value); }

template <class Real>
class BoundsOfFaces {
 public:
  BoundsOfFaces(const Topology& mesh, const FaceDepths* depths, Session& session)
      : mesh_(mesh), depths_(depths), session_(session), bounds_(mesh.faces.size()) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    for (FaceBounds& each : bounds_) {
      each.low.fill(kInfinity);
      each.high.fill(-kInfinity);
    }
  }

  void add_base(std::span<const std::byte> base) {
    const auto* const vertices = reinterpret_cast<const Real*>(base.data());
    for (FaceId face = 0; face < bounds_.size(); ++face)
      for (const VertexId corner : mesh_.faces[face]) {
        Range range;
        range.add(vertices + std::size_t{3} * corner, 1);
        merge(face, range);
      }
  }

  /// `read(bytes)` is called after each block.
  template <class Read>
  void add_level(const LevelFile& level, Read read) {
    const LevelGeometry& geometry = level.geometry;
    std::uint64_t ahead = 0;
    for (std::uint64_t block = 0; block < geometry.block_count(); ++block) {
      const PinnedBlock pinned = session_.pin(level, block);
      ahead = std::max(ahead, block + 1);
      while (ahead < geometry.block_count() && session_.prefetch(level, ahead)) ++ahead;
      const std::uint64_t offset = geometry.block_offset(block);
      for (EdgeId edge = geometry.first_edge(block); edge < geometry.edge_after(block); ++edge) {
        const Slot slot = geometry.slot(edge);
        if (slot.shape == SlotShape::kAbsent) continue;
        add_slot(mesh_.edges[edge], slot.shape, geometry.level(),
                 reinterpret_cast<const Real*>(pinned.bytes().data() + (slot.offset - offset)));
      }
      read(geometry.block_bytes(block));
    }
  }

  std::vector<FaceBounds> take() { return std::move(bounds_); }

 private:
  /// Smallest and largest coordinates. Comparisons with a NaN are false, so it does not count.
  struct Range {
    static constexpr std::size_t kLanes = 12;  ///< four vertices at once
    std::array<Real, kLanes> low, high;
    Range() {
      low.fill(std::numeric_limits<Real>::infinity());
      high.fill(-std::numeric_limits<Real>::infinity());
    }
    void add(const Real* vertices, std::int64_t count) {
      for (; count >= 4; count -= 4, vertices += kLanes) add_lanes<kLanes>(vertices);
      for (; count > 0; --count, vertices += 3) add_lanes<3>(vertices);
    }
    template <std::size_t kCount>
    void add_lanes(const Real* values) {
      for (std::size_t lane = 0; lane < kCount; ++lane) {
        low[lane] = values[lane] < low[lane] ? values[lane] : low[lane];
        high[lane] = values[lane] > high[lane] ? values[lane] : high[lane];
      }
    }
  };

  void merge(FaceId face, const Range& range) {
    FaceBounds& bounds = bounds_[face];
    for (std::size_t lane = 0; lane < Range::kLanes; ++lane) {
      const std::size_t axis = lane % 3;
      bounds.low[axis] = std::min(bounds.low[axis], rounded_down(range.low[lane]));
      bounds.high[axis] = std::max(bounds.high[axis], rounded_up(range.high[lane]));
    }
  }

  /// The records with row + column <= n - 1 are in the own face, those with row + column >= n - 1
  /// in the other one. Row r of a half slot has n - r records, all in the face that it belongs to.
  void add_slot(const Edge& edge, SlotShape shape, BaseRelativeLevel level, const Real* row) {
    const std::int64_t n = slot_side(level.refinements);
    Range own, other;
    for (std::int64_t r = 0; r < n; ++r) {
      own.add(row, n - r);
      if (shape == SlotShape::kHalf) {
        row += 3 * (n - r);
        continue;
      }
      other.add(row + 3 * (n - 1 - r), r + 1);
      row += 3 * n;
    }
    if (shape == SlotShape::kHalf && depths_ != nullptr && !depths_->own_face_has(edge, level))
      return merge(edge.other.face(), own);
    merge(edge.own.face(), own);
    if (shape == SlotShape::kWhole) merge(edge.other.face(), other);
  }

  const Topology& mesh_;
  const FaceDepths* depths_;
  Session& session_;
  std::vector<FaceBounds> bounds_;
};

template <class Real>
std::vector<FaceBounds> compute(const BaseMesh& mesh, std::span<const std::byte> base,
                                std::span<const LevelFile* const> levels, Session& session,
                                const ProgressCallback& progress) {
  std::uint64_t done = 0, total = 0;
  for (const LevelFile* const level : levels) total += level->geometry.total_bytes();
  const Topology topology = mesh.topology();
  BoundsOfFaces<Real> bounds(topology, mesh.depths(), session);
  bounds.add_base(base);
  for (const LevelFile* const level : levels)
    bounds.add_level(*level, [&](std::uint64_t bytes) {
      done += bytes;
      if (progress && !progress({"bounds", done, total}))
        throw Error(ErrorCode::kCancelled, "compute bounds: cancelled");
    });
  return bounds.take();
}

}  // namespace

std::vector<FaceBounds> compute_face_bounds(const BaseMesh& mesh, const AttributeSchema& schema,
                                            std::span<const std::byte> base,
                                            std::span<const LevelFile* const> levels,
                                            Session& session, const ProgressCallback& progress) {
  return schema.type == ComponentType::kFloat32
             ? compute<float>(mesh, base, levels, session, progress)
             : compute<double>(mesh, base, levels, session, progress);
}

PLAIT_END_NAMESPACE
