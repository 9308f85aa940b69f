#include "sample/samples.h"

#include <algorithm>

#include "base/threads.h"
#include "mesh/parallel_parts.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The number of faces that are sampled between two calls of the progress callback.
constexpr std::size_t kFacesAtOnce = 1 << 16;

}  // namespace

std::vector<SurfacePoint> sample_scan(const CollapseHistory& history, const BaseMesh& base,
                                      std::span<const FaceId> history_faces, int level,
                                      const ProgressCallback& progress) {
  const SampleNumbers numbers(base, level);
  const Topology topology = base.topology();
  const std::int64_t size = numbers.size();
  std::vector<SurfacePoint> samples(numbers.count());

  const auto owns = [&](FaceId face, std::int64_t i, std::int64_t j) {
    const std::int64_t k = size - i - j;
    if (i == size || j == size || k == size) {
      const int corner = i == size ? 1 : j == size ? 2 : 0;
      const VertexId vertex = topology.faces[face][static_cast<std::size_t>(corner)];
      return topology.vertex_corners[vertex] == FaceSide(face, corner);
    }
    if (k == 0) return topology.is_own(face, 0);
    if (i == 0) return topology.is_own(face, 1);
    return j != 0 || topology.is_own(face, 2);
  };
  const auto sample_face = [&](FaceId face) {
    const double part = 1 / static_cast<double>(size);
    for (std::int64_t j = 0; j <= size; ++j)
      for (std::int64_t i = 0; i + j <= size; ++i) {
        if (!owns(face, i, j)) continue;
        samples[numbers.of(face, i, j)] =
            history.follow_back({history_faces[face],
                                 {static_cast<double>(size - i - j) * part,
                                  static_cast<double>(i) * part, static_cast<double>(j) * part}});
      }
  };
  for (std::size_t first = 0; first < base.face_count(); first += kFacesAtOnce) {
    if (progress && !progress({"samples", first, base.face_count()}))
      throw Error(ErrorCode::kCancelled, "remesh: cancelled, samples");
    const std::size_t count = std::min<std::size_t>(kFacesAtOnce, base.face_count() - first);
    constexpr std::size_t kFacesOfPart = 256;
    each_on_workers(std::size_t{0}, (count + kFacesOfPart - 1) / kFacesOfPart,
                    [&](std::size_t part) {
                      const std::size_t end = std::min(count, (part + 1) * kFacesOfPart);
                      for (std::size_t i = part * kFacesOfPart; i < end; ++i)
                        sample_face(static_cast<FaceId>(first + i));
                    });
  }
  return samples;
}

PLAIT_END_NAMESPACE
