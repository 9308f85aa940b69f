#include "sample/relax.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "base/threads.h"
#include "plait/error.h"
#include "sample/oriented_scan.h"
#include "sample/sample_ring.h"
#include "sample/walk.h"
#include "surface/paced_ranges.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// A triangle may lean so far from the scan (cosine of the angle), or as far as it did.
constexpr double kLeastTurn = 0.3;
constexpr double kLeastGain = 0.005;  ///< of the estimate: smaller gains are no move
/// Parts of the ways to the middle of the neighbours, in full rounds, and to each neighbour, that a
/// sample tries.
constexpr std::array<double, 2> kPartsToMiddle = {1.0, 0.4};
constexpr double kFirstPartToNeighbour = 0.2;
/// In each round, the way to a neighbour is so much of that in the round before.
constexpr double kShorter = 0.85;
constexpr std::size_t kFacesOfTask = 64;

/// A small triangle as one of its corners sees it.
struct RingTriangle {
  std::uint32_t second, third;
  FaceId face;  ///< of the base mesh
};

class Relaxation {
 public:
  Relaxation(const Surface& scan, const BaseMesh& base, int level, const RelaxOptions& options,
             std::vector<SurfacePoint>& samples)
      : scan_(scan),
        base_(base),
        topology_(base.topology()),
        numbers_(base, level),
        options_(options),
        steps_(static_cast<std::uint64_t>(options.rounds) *
               (2 * base.face_count() + topology_.edges.size() + base.vertex_count())),
        samples_(samples),
        places_(samples.size()),
        errors_(samples.size(), 0),
        first_(samples.size() + 1, 0),
        mean_areas_(base.face_count(), 0),
        fixed_(samples.size(), 0),
        moved_before_(samples.size(), 1),
        moved_now_(samples.size(), 0),
        moved_ever_(samples.size(), 0) {
    set_places();
    gather();
    find_borders();
    find_still_samples();
  }

  std::uint64_t run() {
    for (int round = 0; round < options_.rounds; ++round) {
      if (round == options_.full_rounds) {
        full_ = false;
        least_error_ = mean_error();
      }
      relax_round();
      part_to_neighbour_ *= kShorter;
    }
    return static_cast<std::uint64_t>(std::count(moved_ever_.begin(), moved_ever_.end(), 1));
  }

 private:
  /// Ends the work if it shall not go on.
  void tell() const {
    if (options_.progress && !options_.progress({"relax", done_, steps_}))
      throw Error(ErrorCode::kCancelled, "remesh: cancelled, relax");
  }
  /// Calls work(first, last) for ranges that follow each other, and counts them if `counts`.
  template <class Work>
  void in_steps(std::size_t count, bool counts, const Work& work) {
    const std::uint64_t before = done_;
    const auto step = [&](std::size_t done) {
      if (counts) done_ = before + done;
      tell();
    };
    for_paced_ranges(count, {}, step, work);
    if (counts) done_ = before + count;
  }
  template <class Work>
  void for_faces(bool counts, const Work& work) {
    in_steps(base_.face_count(), counts, [&](std::size_t begin, std::size_t end) {
      ranges_on_workers(end - begin, kFacesOfTask, [&](std::size_t first, std::size_t last) {
        SampleRing ring;
        for (std::size_t face = begin + first; face < begin + last; ++face)
          work(static_cast<FaceId>(face), ring);
      });
    });
  }

  void set_places();
  void gather();
  void find_borders();
  void find_still_samples();
  double mean_error() const {
    return std::accumulate(errors_.begin(), errors_.end(), 0.0) /
           static_cast<double>(errors_.size());
  }
  void relax_round();
  void relax_sample(std::uint64_t sample, SampleRing& ring);

  const OrientedScan scan_;
  const BaseMesh& base_;
  const Topology topology_;
  const SampleNumbers numbers_;
  const RelaxOptions& options_;
  double part_to_neighbour_ = kFirstPartToNeighbour, least_error_ = 0;
  bool full_ = true;  ///< the round
  std::uint64_t done_ = 0, steps_;
  std::vector<SurfacePoint>& samples_;
  std::vector<OrientedPoint> places_;  ///< [sample]
  std::vector<double> errors_;         ///< [sample] of the ring, when it was last looked at
  std::vector<std::uint32_t> first_;
  std::vector<RingTriangle> around_;  ///< sample s has those from first_[s] to first_[s + 1]
  std::vector<double> mean_areas_;    ///< [base face] twice the area, as area_vector() has it
  // Bytes, because threads write neighbours at once.
  std::vector<std::uint8_t> fixed_;                     ///< on a border, or still
  std::vector<std::uint8_t> moved_before_, moved_now_;  ///< in the round before, and in this one
  std::vector<std::uint8_t> moved_ever_;
};

void Relaxation::set_places() {
  ranges_on_workers(samples_.size(), 1024, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) places_[i] = scan_.at(samples_[i]);
  });
}

void Relaxation::gather() {
  const auto for_each_corner = [&](FaceId face, auto work) {
    numbers_.for_each_triangle(face, [&](std::uint64_t a, std::uint64_t b, std::uint64_t c) {
      const auto i = static_cast<std::uint32_t>(a), j = static_cast<std::uint32_t>(b),
                 k = static_cast<std::uint32_t>(c);
      work(i, j, k);
      work(j, k, i);
      work(k, i, j);
    });
  };
  const auto for_each_face = [&](auto work) {
    in_steps(base_.face_count(), false, [&](std::size_t first, std::size_t last) {
      for (std::size_t face = first; face < last; ++face) work(static_cast<FaceId>(face));
    });
  };
  for_each_face([&](FaceId face) {
    for_each_corner(face, [&](std::uint32_t at, std::uint32_t, std::uint32_t) { ++first_[at]; });
  });
  std::uint32_t sum = 0;
  for (std::uint32_t& count : first_) sum += std::exchange(count, sum);
  around_.resize(sum);
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for_each_face([&](FaceId face) {
    for_each_corner(face, [&](std::uint32_t at, std::uint32_t second, std::uint32_t third) {
      around_[next[at]++] = {second, third, face};
    });
  });
  const auto count = static_cast<double>(numbers_.size() * numbers_.size());
  for_faces(false, [&](FaceId face, SampleRing&) {
    double areas = 0;
    numbers_.for_each_triangle(face, [&](std::uint64_t a, std::uint64_t b, std::uint64_t c) {
      areas += length(area_vector(places_[a].position, places_[b].position, places_[c].position));
    });
    mean_areas_[face] = std::max(areas / count, 1e-300);
  });
}

void Relaxation::find_borders() {
  for (const EdgeId edge : topology_.border_edges) {
    const FaceSide side = topology_.edges[edge].own;
    for (std::int64_t part = 0; part <= numbers_.size(); ++part)
      fixed_[numbers_.on_side(side, part)] = 1;
  }
}

void Relaxation::find_still_samples() {
  for (std::size_t sample = 0; sample < options_.still_samples.size(); ++sample)
    fixed_[sample] |= options_.still_samples[sample];
  for (FaceId face = 0; face < options_.still_faces.size(); ++face)
    if (options_.still_faces[face] != 0)
      numbers_.for_each_triangle(face, [&](std::uint64_t a, std::uint64_t b, std::uint64_t c) {
        fixed_[a] = fixed_[b] = fixed_[c] = 1;
      });
}

void Relaxation::relax_sample(std::uint64_t sample, SampleRing& ring) {
  const std::span<const RingTriangle> triangles(around_.data() + first_[sample],
                                                first_[sample + 1] - first_[sample]);
  if (fixed_[sample] != 0 || errors_[sample] < least_error_) return;
  if (moved_before_[sample] == 0 && std::ranges::none_of(triangles, [&](const RingTriangle& t) {
        return moved_before_[t.second] != 0;
      }))
    return;
  const OrientedPoint now = places_[sample];
  Point middle{0, 0, 0};
  ring.clear();
  for (const RingTriangle& t : triangles) {
    ring.add(places_[t.second], places_[t.third], mean_areas_[t.face]);
    middle = middle + places_[t.second].position;
  }
  const RingEstimate first = ring.estimate(now);
  errors_[sample] = first.error;
  RingLimits limits = {(1 - kLeastGain) * first.error, std::min(kLeastTurn, first.least_turn),
                       std::max(options_.most_ratio, first.most_ratio)};
  const Walk from(scan_.surface(), samples_[sample]);
  SurfacePoint best;
  OrientedPoint best_place;
  const auto offer = [&](Point way) {
    const SurfacePoint there = from.along(way);
    const OrientedPoint place = scan_.at(there);
    const std::optional<double> error = ring.error_within(place, limits);
    if (!error) return;
    limits.error = *error;
    best = there;
    best_place = place;
  };
  if (full_) {
    const Point to_middle = (1 / static_cast<double>(triangles.size())) * middle - now.position;
    const Point along = to_middle - dot(to_middle, now.normal) * now.normal;
    for (const double part : kPartsToMiddle) offer(part * along);
  }
  for (const RingTriangle& t : triangles)
    offer(part_to_neighbour_ * (places_[t.second].position - now.position));
  if (best.face == kNoId) return;
  samples_[sample] = best;
  places_[sample] = best_place;
  moved_now_[sample] = moved_ever_[sample] = 1;
}

void Relaxation::relax_round() {
  const std::int64_t size = numbers_.size();
  // A sample reads its neighbours, so no two neighbours move at once: first those inside of faces,
  // then those on edges that are not next to a base vertex, in the end the others, one by one.
  for_faces(true, [&](FaceId face, SampleRing& ring) {
    for (std::int64_t j = 1; j < size; ++j)
      for (std::int64_t i = 1; i + j < size; ++i) relax_sample(numbers_.of(face, i, j), ring);
  });
  for_faces(true, [&](FaceId face, SampleRing& ring) {
    for (int side = 0; side < 3; ++side)
      if (topology_.is_own(face, side))
        for (std::int64_t part = 2; part + 2 <= size; ++part)
          relax_sample(numbers_.on_side(FaceSide(face, side), part), ring);
  });
  SampleRing ring;
  in_steps(topology_.edges.size(), true, [&](std::size_t first, std::size_t last) {
    for (std::size_t edge = first; edge < last; ++edge)
      for (const std::int64_t part : {std::int64_t{1}, size - 1}) {
        const FaceSide own = topology_.edges[edge].own;
        relax_sample(numbers_.on_side(own, part), ring);
      }
  });
  in_steps(base_.vertex_count(), true, [&](std::size_t first, std::size_t last) {
    for (std::size_t vertex = first; vertex < last; ++vertex) relax_sample(vertex, ring);
  });
  std::swap(moved_before_, moved_now_);
  std::fill(moved_now_.begin(), moved_now_.end(), std::uint8_t{0});
}

}  // namespace

std::uint64_t relax(const Surface& scan, const BaseMesh& base, int level,
                    const RelaxOptions& options, std::vector<SurfacePoint>& samples) {
  return Relaxation(scan, base, level, options, samples).run();
}

PLAIT_END_NAMESPACE
