#include <tbb/parallel_sort.h>

#include <cstddef>
#include <numeric>
#include <utility>

#include "base/interruption.h"
#include "base/threads.h"
#include "layout/hilbert_cells.h"
#include "layout/reverse_cuthill_mckee.h"
#include "plait/error.h"
#include "plait/layout.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

GrowingBox box_of(std::span<const Vector3<double>> positions) {
  GrowingBox box;
  for (const Vector3<double>& p : positions) box.add(p);
  return box;
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
  const std::span<const Vector3<double>> p = mesh.positions();
  const Vector3<double> extent = box_of(p).halved_extent();
  int longest = 0;
  for (int axis = 1; axis < 3; ++axis)
    if (extent[axis] > extent[longest]) longest = axis;
  return sorted_by(mesh.face_count(), [&](FaceId face) {
    const auto& [a, b, c] = mesh.faces()[face];
    return centroid(p[a], p[b], p[c], longest);
  });
}

std::vector<FaceId> hilbert_order(const BaseMesh& mesh) {
  const std::span<const Vector3<double>> p = mesh.positions();
  const HilbertCells cells(box_of(p));
  return sorted_by(mesh.face_count(), [&](FaceId face) {
    const auto& [a, b, c] = mesh.faces()[face];
    return cells.key(p[a], p[b], p[c]);
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
