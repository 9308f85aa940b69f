#include "sample/untangle.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "plait/error.h"
#include "sample/turned.h"
#include "sample/walk.h"
#include "surface/paced_ranges.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// A triangle has no penalty if its normal is within this cosine of the scan's.
constexpr double kWellTurned = 0.3;
/// Parts of the way to the middle of the neighbours that a sample tries.
constexpr std::array<double, 4> kParts = {1.0, 0.5, 0.25, 0.1};
/// Rings around a turned triangle whose samples may move.
constexpr int kRings = 2;

using SampleTriangle = std::array<std::uint32_t, 3>;

class Untangler {
 public:
  Untangler(const Surface& scan, const BaseMesh& base, int level, const UntangleOptions& options,
            std::vector<SurfacePoint>& samples)
      : scan_(scan), base_(base), numbers_(base, level), options_(options), samples_(samples) {}

  Untangled run() {
    Untangled result;
    std::vector<std::uint8_t> near(samples_.size(), 0);
    for_each_triangle([&](const SampleTriangle& t) {
      if (!turned(t)) return;
      ++result.before;
      for (const std::uint32_t sample : t) near[sample] = 1;
    });
    if (result.before == 0) return result;
    grow(near);
    gather(near);
    const std::vector<SurfacePoint> first = samples_;
    for (int round = 0; round < options_.rounds; ++round)
      if (!relax(first)) break;
    for (std::size_t i = 0; i < samples_.size(); ++i)
      if (samples_[i].face != first[i].face || samples_[i].weights != first[i].weights)
        ++result.moved;
    for_each_triangle([&](const SampleTriangle& t) { result.after += turned(t) ? 1u : 0u; });
    return result;
  }

 private:
  /// Calls work(first, last) for ranges that follow each other: one step of the work.
  template <class Work>
  void in_steps(std::size_t count, const Work& work) {
    const auto go_on = [&](std::size_t) {
      if (options_.progress && !options_.progress({"untangle", done_, steps()}))
        throw Error(ErrorCode::kCancelled, "remesh: cancelled, untangle");
    };
    for_paced_ranges(count, {}, go_on, work);
    ++done_;
  }
  /// As many as there are at most: marks, rings, lists, rounds, count.
  std::uint64_t steps() const { return static_cast<std::uint64_t>(options_.rounds + kRings + 3); }

  template <class Work>
  void for_each_triangle(const Work& work) {
    in_steps(base_.face_count(), [&](std::size_t first, std::size_t last) {
      for (std::size_t face = first; face < last; ++face)
        numbers_.for_each_triangle(
            static_cast<FaceId>(face), [&](std::uint64_t a, std::uint64_t b, std::uint64_t c) {
              work({static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b),
                    static_cast<std::uint32_t>(c)});
            });
    });
  }
  bool turned(const SampleTriangle& t) const {
    return is_turned(scan_, samples_[t[0]], samples_[t[1]], samples_[t[2]],
                     options_.cut != nullptr);
  }

  /// Marks the samples of kRings rings around the marked ones.
  void grow(std::vector<std::uint8_t>& near) {
    for (int ring = 1; ring <= kRings; ++ring)
      for_each_triangle([&](const SampleTriangle& t) {
        const auto is_inside = [&](std::uint32_t s) { return near[s] != 0 && near[s] <= ring; };
        if (!is_inside(t[0]) && !is_inside(t[1]) && !is_inside(t[2])) return;
        for (const std::uint32_t sample : t)
          if (near[sample] == 0) near[sample] = static_cast<std::uint8_t>(ring + 1);
      });
  }

  /// Lists the marked samples, and the triangles around each.
  void gather(const std::vector<std::uint8_t>& near) {
    std::vector<std::uint32_t> place(samples_.size(), kNoId);
    for (std::uint32_t sample = 0; sample < samples_.size(); ++sample)
      if (near[sample] != 0) {
        place[sample] = static_cast<std::uint32_t>(movable_.size());
        movable_.push_back(sample);
      }
    around_.resize(movable_.size());
    for_each_triangle([&](const SampleTriangle& t) {
      for (std::size_t corner = 0; corner < 3; ++corner)
        if (const std::uint32_t at = place[t[corner]]; at != kNoId)
          around_[at].push_back({t[corner], t[(corner + 1) % 3], t[(corner + 2) % 3]});
    });
    // Around an inner sample, each neighbour is the second corner once and the third once.
    fixed_.resize(movable_.size());
    for (std::size_t i = 0; i < movable_.size(); ++i) {
      std::vector<std::uint32_t> second, third;
      for (const SampleTriangle& t : around_[i]) {
        second.push_back(t[1]);
        third.push_back(t[2]);
      }
      std::sort(second.begin(), second.end());
      std::sort(third.begin(), third.end());
      fixed_[i] = second != third ||
                  (!options_.still_samples.empty() && options_.still_samples[movable_[i]] != 0);
    }
  }

  double penalty(std::size_t place, const SurfacePoint& at) const {
    const Point p = position_of(scan_, at), own = face_normal(scan_, at.face);
    double sum = 0;
    for (const SampleTriangle& t : around_[place]) {
      const Point q = position_of(scan_, samples_[t[1]]), r = position_of(scan_, samples_[t[2]]);
      const Point normal = area_vector(p, q, r);
      const Point expected =
          own + face_normal(scan_, samples_[t[1]].face) + face_normal(scan_, samples_[t[2]].face);
      const double lengths = length(normal) * length(expected);
      const double cosine = lengths > 0 ? dot(normal, expected) / lengths : 0;
      if (cosine < kWellTurned) sum += 1 + kWellTurned - cosine;
      // Among good triangles, the ones that are no needles.
      const double quality = triangle_quality(
          length(normal), squared_length(q - p) + squared_length(r - q) + squared_length(p - r));
      sum += 0.1 * (1 - quality);
    }
    return sum;
  }

  bool relax(const std::vector<SurfacePoint>& first) {
    bool any = false;
    in_steps(movable_.size(), [&](std::size_t from, std::size_t to) {
      for (std::size_t place = from; place < to; ++place)
        if (!fixed_[place]) any = relax_sample(place, first) || any;
    });
    return any;
  }

  /// Returns whether the sample moved.
  bool relax_sample(std::size_t place, const std::vector<SurfacePoint>& first) {
    SurfacePoint& sample = samples_[movable_[place]];
    const Point p = position_of(scan_, sample), origin = position_of(scan_, first[movable_[place]]);
    Point middle{0, 0, 0};
    double edges = 0;
    bool bad = false;
    for (const SampleTriangle& t : around_[place]) {
      const Point q = position_of(scan_, samples_[t[1]]);
      middle = middle + q;
      edges += length(q - p);
      bad = bad || turned(t);
    }
    const double count = static_cast<double>(around_[place].size());
    const double most_way = options_.most_way * edges / count;
    double least = penalty(place, sample);
    if (!bad && least < 1) return false;
    SurfacePoint best = sample;
    const auto offer = [&](Point way) {
      const SurfacePoint there = walk(options_.cut != nullptr ? *options_.cut : scan_, sample, way);
      if (length(position_of(scan_, there) - origin) > most_way) return;
      const double now = penalty(place, there);
      if (now < 0.999 * least) {
        least = now;
        best = there;
      }
    };
    const Point way = (1 / count) * middle - p;
    for (const double part : kParts) offer(part * way);
    if (bad)  // towards each neighbour, and away from it
      for (const SampleTriangle& t : around_[place]) {
        const Point to = position_of(scan_, samples_[t[1]]) - p;
        offer(0.3 * to);
        offer(-0.3 * to);
      }
    if (best.face == sample.face && best.weights == sample.weights) return false;
    sample = best;
    return true;
  }

  const Surface& scan_;
  const BaseMesh& base_;
  SampleNumbers numbers_;
  UntangleOptions options_;
  std::vector<SurfacePoint>& samples_;
  std::vector<std::uint32_t> movable_;               ///< samples near turned triangles
  std::vector<std::vector<SampleTriangle>> around_;  ///< [place] each begins with the sample
  std::vector<bool> fixed_;                          ///< on a border, or still
  std::uint64_t done_ = 0;                           ///< steps
};

}  // namespace

Untangled untangle(const Surface& scan, const BaseMesh& base, int level,
                   const UntangleOptions& options, std::vector<SurfacePoint>& samples) {
  return Untangler(scan, base, level, options, samples).run();
}

PLAIT_END_NAMESPACE
