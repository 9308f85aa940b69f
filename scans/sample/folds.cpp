#include "sample/folds.h"

#include <atomic>
#include <cstddef>

#include "base/threads.h"
#include "plait/extend/topology.h"
#include "sample/samples.h"
#include "surface/repair.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

class FoldCount {
 public:
  FoldCount(const BaseMesh& base, int level, std::span<const Point> positions)
      : topology_(base.topology()), numbers_(base, level), positions_(positions) {}

  std::uint64_t of_face(FaceId face) const {
    const std::int64_t size = numbers_.size();
    std::uint64_t count = 0;
    for (std::int64_t j = 0; j + 1 < size; ++j)
      for (std::int64_t i = 0; i + j + 1 < size; ++i) {
        // The triangle between three others of the face.
        const Point a = at(face, i + 1, j), b = at(face, i + 1, j + 1), c = at(face, i, j + 1);
        const Point middle = area_vector(a, b, c);
        count += is_folded(middle, area_vector(at(face, i, j), a, c)) ? 1u : 0u;
        count += is_folded(middle, area_vector(a, at(face, i + 2, j), b)) ? 1u : 0u;
        count += is_folded(middle, area_vector(c, b, at(face, i, j + 2))) ? 1u : 0u;
      }
    return count;
  }

  std::uint64_t of_edge(const Edge& edge) const {
    if (!edge.other.exists()) return 0;
    const std::int64_t size = numbers_.size();
    std::uint64_t count = 0;
    for (std::int64_t part = 0; part < size; ++part)
      count += is_folded(beside(edge.own, part), beside(edge.other, size - 1 - part)) ? 1u : 0u;
    return count;
  }

 private:
  Point at(FaceId face, std::int64_t i, std::int64_t j) const {
    return positions_[numbers_.of(face, i, j)];
  }
  /// The area vector of the triangle at part `part` of a side.
  Point beside(FaceSide side, std::int64_t part) const {
    const FaceId face = side.face();
    const std::int64_t rest = numbers_.size() - 1 - part;
    std::int64_t i = part, j = 0;
    if (side.side() == 0) i = rest, j = part;
    if (side.side() == 1) i = 0, j = rest;
    return area_vector(at(face, i, j), at(face, i + 1, j), at(face, i, j + 1));
  }

  const Topology topology_;
  const SampleNumbers numbers_;
  std::span<const Point> positions_;
};

}  // namespace

std::uint64_t count_folds(const BaseMesh& base, int level, std::span<const Point> positions) {
  const FoldCount folds(base, level, positions);
  const Topology topology = base.topology();
  std::atomic<std::uint64_t> count{0};
  constexpr std::size_t kAtOnce = 64;
  ranges_on_workers(base.face_count(), kAtOnce, [&](std::size_t first, std::size_t last) {
    std::uint64_t here = 0;
    for (std::size_t face = first; face < last; ++face)
      here += folds.of_face(static_cast<FaceId>(face));
    count += here;
  });
  ranges_on_workers(topology.edges.size(), kAtOnce, [&](std::size_t first, std::size_t last) {
    std::uint64_t here = 0;
    for (std::size_t edge = first; edge < last; ++edge) here += folds.of_edge(topology.edges[edge]);
    count += here;
  });
  return count;
}

PLAIT_END_NAMESPACE
