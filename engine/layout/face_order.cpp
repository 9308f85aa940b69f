#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>
#include <utility>

#include "base/interruption.h"
#include "base/threads.h"
#include "layout/hilbert.h"
#include "layout/reverse_cuthill_mckee.h"
#include "plait/error.h"
#include "plait/layout.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The bounding box of the vertices, with all coordinates halved: so differences of finite
/// positions do not overflow.
struct HalvedBox {
  Vector3<double> lowest{}, extent{};

  explicit HalvedBox(std::span<const Vector3<double>> positions) {
    if (positions.empty()) return;
    Vector3<double> highest = lowest = positions.front();
    for (const Vector3<double>& p : positions) {
      for (int axis = 0; axis < 3; ++axis) {
        lowest[axis] = std::min(lowest[axis], p[axis]);
        highest[axis] = std::max(highest[axis], p[axis]);
      }
    }
    lowest = 0.5 * lowest;
    extent = 0.5 * highest - lowest;
  }
};

double centroid(const BaseMesh& mesh, FaceId face, int axis) {
  const auto& [a, b, c] = mesh.faces()[face];
  const std::span<const Vector3<double>> p = mesh.positions();
  return p[a][axis] / 3 + p[b][axis] / 3 + p[c][axis] / 3;
}

/// The faces in ascending order of their keys. Faces with equal keys keep their order.
template <class KeyOf>
std::vector<FaceId> sorted_by(std::size_t face_count, KeyOf key_of) {
  using Key = decltype(key_of(FaceId{}));
  std::vector<std::pair<Key, FaceId>> keyed_faces(face_count);
  ranges_on_workers(face_count, 1 << 14, [&](std::size_t first, std::size_t last) {
    poll_interruption();
    for (std::size_t face = first; face < last; ++face)
      keyed_faces[face] = {key_of(static_cast<FaceId>(face)), static_cast<FaceId>(face)};
  });
  on_workers([&] { tbb::parallel_sort(keyed_faces.begin(), keyed_faces.end()); });
  std::vector<FaceId> order(keyed_faces.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = keyed_faces[i].second;
  return order;
}

std::vector<FaceId> spatial_order(const BaseMesh& mesh) {
  const Vector3<double> extent = HalvedBox(mesh.positions()).extent;
  int longest = 0;
  for (int axis = 1; axis < 3; ++axis)
    if (extent[axis] > extent[longest]) longest = axis;
  return sorted_by(mesh.face_count(), [&](FaceId face) { return centroid(mesh, face, longest); });
}

std::vector<FaceId> hilbert_order(const BaseMesh& mesh) {
  const HalvedBox box(mesh.positions());
  // All axes have the same scale, so cells are cubes. This keeps neighbours on the curve close in
  // space.
  const double size = std::max({box.extent.x, box.extent.y, box.extent.z});
  constexpr double kLastCell = (1 << layout::kHilbertBits) - 1;
  return sorted_by(mesh.face_count(), [&](FaceId face) {
    std::array<std::uint32_t, 3> cell{};
    for (int axis = 0; axis < 3; ++axis) {
      const double offset = 0.5 * centroid(mesh, face, axis) - box.lowest[axis];
      // Rounding may put a centroid a little outside the box. If the box has no size, every cell is
      // 0.
      if (offset > 0)
        cell[static_cast<std::size_t>(axis)] =
            static_cast<std::uint32_t>(std::min(offset / size, 1.0) * kLastCell);
    }
    return layout::hilbert_key(cell);
  });
}

}  // namespace

std::vector<FaceId> face_order(const BaseMesh& mesh, LayoutKind kind) {
  switch (kind) {
    case LayoutKind::kGiven:
      break;
    case LayoutKind::kSpatial:
      return spatial_order(mesh);
    case LayoutKind::kHilbert:
      return hilbert_order(mesh);
    case LayoutKind::kRcm:
      return layout::reverse_cuthill_mckee(mesh.topology());
    case LayoutKind::kAutomatic:
      throw Error(ErrorCode::kInvalidArgument,
                  "order faces: expected an order, found \"auto\", which chooses one");
  }
  std::vector<FaceId> order(mesh.face_count());
  std::iota(order.begin(), order.end(), FaceId{0});
  return order;
}

PLAIT_END_NAMESPACE
