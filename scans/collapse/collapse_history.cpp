#include "collapse/collapse_history.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::size_t kHeaderWords = 6;

/// Where the parts of a record are.
struct RecordShape {
  explicit RecordShape(std::uint32_t word)
      : faces(word & 63u),
        lost_faces(word >> 6 & 3u),
        closed((word >> 8 & 1u) != 0),
        apex{word >> 9 & 63u, word >> 15 & 63u},
        kept_stays((word >> 21 & 1u) != 0),
        crease_spoke(word >> 22 & 63u) {}

  std::size_t faces, lost_faces;
  bool closed;
  std::array<std::size_t, 2> apex;
  bool kept_stays;           ///< so its spokes are what they were
  std::size_t crease_spoke;  ///< 1 more than its place in the ring, or 0: `gone` was on it

  std::size_t ring_size() const { return closed ? faces : faces + 1; }
  std::size_t corners() const { return kHeaderWords + 2 * ring_size(); }
  std::size_t earlier() const { return corners() + faces + lost_faces; }
  std::size_t words() const { return earlier() + faces + lost_faces; }
  std::size_t next(std::size_t i) const { return closed && i + 1 == faces ? 0 : i + 1; }
};

PlaneVector plane_point(const std::uint32_t* words) {
  return {double{std::bit_cast<float>(words[0])}, double{std::bit_cast<float>(words[1])}};
}

double turn(PlaneVector a, PlaneVector b, PlaneVector p) {
  return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
}

/// The face whose smallest barycentric coordinate is the largest so far.
struct Nearest {
  double least = -1e300;
  std::array<double, 3> weights{};  ///< at the corner `corner` of the face, and the two after it
  std::size_t face = 0;             ///< of the fan, or, after those, one that is lost

  void offer(PlaneVector a, PlaneVector b, PlaneVector c, PlaneVector p, std::size_t candidate) {
    const std::array<double, 3> areas = {turn(b, c, p), turn(c, a, p), turn(a, b, p)};
    const double sum = areas[0] + areas[1] + areas[2];
    const double smallest = std::min({areas[0], areas[1], areas[2]}) / sum;
    if (smallest <= least) return;
    least = smallest;
    weights = {areas[0] / sum, areas[1] / sum, areas[2] / sum};
    face = candidate;
  }
};

double length(PlaneVector a) { return std::sqrt(a.x * a.x + a.y * a.y); }

/// A point of a spoke stays on it, without rounding, if the vertex in the middle is where the kept
/// one was. `share` is the weight of the spoke's vertex in the ring. Nothing is found if all faces
/// at the spoke were at the vertex that is gone, and the spoke was none.
template <class IsAtGone, class Ring>
void follow_spoke(const RecordShape& shape, std::size_t spoke, double share, PlaneVector gone,
                  const IsAtGone& is_at_gone, const Ring& ring, Nearest& nearest) {
  const bool was_gone = spoke + 1 == shape.crease_spoke;
  if (was_gone) {
    const double part = length(gone) / length(ring(spoke));
    if (share <= part) {
      nearest = {0, {1 - share / part, share / part, 0}, shape.faces};
      return;
    }
    share = (share - part) / (1 - part);
  }
  const std::size_t before = spoke > 0 ? spoke - 1 : shape.faces - 1;
  if (spoke < shape.faces && is_at_gone(spoke) == was_gone)
    nearest = {0, {1 - share, share, 0}, spoke};
  else if ((shape.closed || spoke > 0) && is_at_gone(before) == was_gone)
    nearest = {0, {1 - share, 0, share}, before};
}

/// Rounding can put a point a little outside of its face.
std::array<double, 3> inside(std::array<double, 3> weights) {
  double sum = 0;
  for (double& weight : weights) sum += weight = std::max(weight, 0.0);
  for (double& weight : weights) weight /= sum;
  return weights;
}

}  // namespace

void CollapseHistory::add(const Patch& patch, const PatchPlane& plane, Room& room) {
  const auto faces = static_cast<std::uint32_t>(patch.faces);
  const auto lost = static_cast<std::uint32_t>(patch.lost_faces);
  const std::uint32_t word = faces | lost << 6 | (patch.closed ? 1u << 8 : 0u) |
                             static_cast<std::uint32_t>(patch.apex[0]) << 9 |
                             static_cast<std::uint32_t>(patch.apex[1]) << 15 |
                             (patch.kept_stays ? 1u << 21 : 0u) |
                             static_cast<std::uint32_t>(patch.crease_at_gone + 1) << 22;
  const RecordShape shape(word);
  if (room.used + shape.words() > kBlockWords) {
    const std::scoped_lock lock(*mutex_);
    if ((blocks_.size() + 1) * kBlockWords > kNone)
      throw Error(ErrorCode::kNotSupported,
                  "remesh: expected at most 16 GiB of collapses, found more: take a coarser scan");
    blocks_.push_back(std::make_unique<std::uint32_t[]>(kBlockWords));
    room = {blocks_.back().get(), static_cast<std::uint32_t>((blocks_.size() - 1) * kBlockWords),
            0};
  }
  std::uint32_t* const to = room.block + room.used;
  const std::uint32_t place = room.first + static_cast<std::uint32_t>(room.used);
  room.used += shape.words();
  std::atomic_ref(collapses_).fetch_add(1, std::memory_order_relaxed);

  to[0] = word;
  to[1] = patch.at_gone;
  std::memcpy(to + 2, &plane.kept, sizeof plane.kept);
  std::memcpy(to + 4, &plane.gone, sizeof plane.gone);
  std::memcpy(to + kHeaderWords, plane.ring.data(), shape.ring_size() * sizeof(PlanePoint));
  std::uint32_t* const corners = to + shape.corners();
  std::uint32_t* const earlier = to + shape.earlier();
  for (std::size_t i = 0; i < faces + lost; ++i) {
    const FaceSide corner = i < faces ? patch.corners[i] : patch.lost[i - faces];
    corners[i] = corner.code;
    earlier[i] = last_[corner.face()];
    if (i < faces) last_[corner.face()] = place;
  }
}

SurfacePoint CollapseHistory::follow_back(SurfacePoint point) const {
  for (std::uint32_t place = last_[point.face]; place != kNone;) {
    const std::uint32_t* const words = record(place);
    const RecordShape shape(words[0]);
    const std::uint32_t* const corners = words + shape.corners();
    const auto ring = [&](std::size_t i) { return plane_point(words + kHeaderWords + 2 * i); };
    std::size_t at = 0;
    while (corners[at] / 3 != point.face) ++at;
    const std::size_t corner = corners[at] % 3;
    const double to_first = point.weights[(corner + 1) % 3],
                 to_next = point.weights[(corner + 2) % 3];
    const PlaneVector first = ring(at), after = ring(shape.next(at));
    const PlaneVector p = {to_first * first.x + to_next * after.x,
                           to_first * first.y + to_next * after.y};

    const PlaneVector kept = plane_point(words + 2), gone = plane_point(words + 4);
    const auto is_at_gone = [&](std::size_t i) { return (words[1] >> i & 1u) != 0; };
    Nearest nearest;
    if (keeps_lines_ && point.weights[corner] == 0)  // the ring is what it was
      nearest = {0, {0, to_first, to_next}, at};
    else if (keeps_lines_ && shape.kept_stays && (to_first == 0 || to_next == 0))
      follow_spoke(shape, to_next == 0 ? at : shape.next(at), to_first + to_next, gone, is_at_gone,
                   ring, nearest);
    for (std::size_t step = 0; step < shape.faces && nearest.least < 0; ++step) {
      // Most points stay in the face that they were in.
      const std::size_t i = at + step < shape.faces ? at + step : at + step - shape.faces;
      nearest.offer(is_at_gone(i) ? gone : kept, ring(i), ring(shape.next(i)), p, i);
    }
    if (nearest.least < 0) {
      nearest.offer(kept, gone, ring(shape.apex[0]), p, shape.faces);
      // The corners of this face in the order that begins at `kept`.
      if (shape.lost_faces == 2) nearest.offer(kept, ring(shape.apex[1]), gone, p, shape.faces + 1);
    }
    const std::uint32_t code = corners[nearest.face];
    const auto weights = inside(nearest.weights);
    point.face = code / 3;
    for (std::size_t i = 0; i < 3; ++i) point.weights[(code + i) % 3] = weights[i];
    // code % 3 is the corner; adding 3 face changes nothing modulo 3.
    place = words[shape.earlier() + nearest.face];
  }
  return point;
}

std::uint64_t CollapseHistory::memory_bytes() const {
  return (blocks_.size() * kBlockWords + last_.size()) * sizeof(std::uint32_t);
}

PLAIT_END_NAMESPACE
