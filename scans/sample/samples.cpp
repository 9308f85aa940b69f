#include "sample/samples.h"

#include "base/threads.h"
#include "mesh/parallel_parts.h"
#include "plait/error.h"
#include "surface/paced_ranges.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::size_t kFacesSampledAtOnce = 16;

}  // namespace

std::vector<std::uint8_t> vertices_on_sides(const BaseMesh& base, int level,
                                            std::span<const std::uint8_t> sides) {
  const SampleNumbers numbers(base, level);
  std::vector<std::uint8_t> on_sides(numbers.count(), 0);
  for (std::uint32_t code = 0; code < sides.size(); ++code) {
    if (sides[code] == 0) continue;
    FaceSide side;
    side.code = code;
    for (std::int64_t part = 0; part <= numbers.size(); ++part)
      on_sides[numbers.on_side(side, part)] = 1;
  }
  return on_sides;
}

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
  for_paced_ranges(
      base.face_count(), {},
      [&](std::size_t done) {
        if (progress && !progress({"samples", done, base.face_count()}))
          throw Error(ErrorCode::kCancelled, "remesh: cancelled, samples");
      },
      [&](std::size_t begin, std::size_t end) {
        ranges_on_workers(end - begin, kFacesSampledAtOnce,
                          [&](std::size_t first, std::size_t last) {
                            for (std::size_t face = begin + first; face < begin + last; ++face)
                              sample_face(static_cast<FaceId>(face));
                          });
      });
  return samples;
}

PLAIT_END_NAMESPACE
