#include "passes/fractal.h"

#include <fmt/format.h>

#include <cmath>
#include <span>
#include <tuple>

#include "normals/ring_normal.h"
#include "passes/gradient_noise.h"
#include "passes/moved_positions.h"
#include "passes/vertex_noise.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

using Wide = Vector3<double>;

constexpr double kFirstWavelength = 0.125;  // of the diagonal
constexpr double kShortestWavelength = 4;   // of the mean edge
constexpr double kNextAmplitude = 0.45;     // of the one before
// A mean edge of 2^-32 diagonals or less counts as 0. Then the octaves end by their number.
constexpr std::size_t kMostOctaves = 32;

/// Adds octaves of noise. Wavelengths and amplitudes are in units of the mesh.
class Fractal {
 public:
  Fractal(const Wide& low, std::span<const double> wavelengths, double amplitude,
          std::uint64_t seed)
      : low_(low) {
    for (const double wavelength : wavelengths) {
      octaves_.push_back({1 / wavelength, amplitude, random_word(seed, octaves_.size())});
      amplitude *= kNextAmplitude;
    }
  }
  double at(const Wide& position) const noexcept {
    const Wide from_low = position - low_;
    double height = 0;
    for (const Octave& octave : octaves_)
      height += octave.amplitude * gradient_noise(octave.frequency * from_low, octave.key);
    return height;
  }

 private:
  struct Octave {
    double frequency, amplitude;
    std::uint64_t key;
  };
  Wide low_;
  std::vector<Octave> octaves_;
};

/// Lengths are added as whole numbers, so that the sum does not depend on threads: 2^32 is the
/// diagonal. Every edge is added twice, once at each end, but where depths of faces differ.
double mean_edge(Store& store, double diagonal, const VisitOptions& options) {
  struct alignas(64) Sum {  // of one thread, in a cache line of its own
    std::uint64_t lengths = 0, count = 0;
  };
  std::vector<Sum> sums(static_cast<std::size_t>(options.threads));
  const double unit = 0x1p32 / diagonal;
  with_real(store, [&]<class Real>(Real) {
    using Point = Vector3<Real>;
    visit_vertices(store, options, std::tuple{rings_of<Point>("position")},
                   [&](const VertexRun& run, const VertexRings<Point>& ring) {
                     Sum& sum = sums[static_cast<std::size_t>(run.worker)];
                     for (std::size_t i = 0; i < run.count; ++i)
                       for (int k = 0; k < ring.valence(); ++k) {
                         const Wide edge = widen(ring.neighbour(i, k)) - widen(ring.vertex(i));
                         const double length = std::sqrt(dot(edge, edge));
                         sum.lengths += static_cast<std::uint64_t>(std::llround(length * unit));
                         ++sum.count;
                       }
                   });
  });
  Sum all;
  for (const Sum& sum : sums) {
    all.lengths += sum.lengths;
    all.count += sum.count;
  }
  return static_cast<double>(all.lengths) / unit / static_cast<double>(all.count);
}

}  // namespace

Waves measure_waves(Store& store, const PositionBox& box, const VisitOptions& options) {
  const double diagonal = box.diagonal();
  Waves waves{mean_edge(store, diagonal, options), {}};
  const double shortest = kShortestWavelength * waves.mean_edge;
  for (double wavelength = kFirstWavelength * diagonal;
       wavelength >= shortest && waves.lengths.size() < kMostOctaves; wavelength /= 2)
    waves.lengths.push_back(wavelength);
  if (waves.lengths.empty())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("pass 'fractal': the mean edge is {:.3g} and the diagonal {:.3g}; the "
                            "first wave is an eighth of the diagonal, and needs edges of a "
                            "thirty-second at most: refine the mesh further",
                            waves.mean_edge, diagonal));
  return waves;
}

Moves add_fractal(Store& store, std::string_view into, double amplitude, std::uint64_t seed,
                  const PositionBox& box, const Waves& waves, const VisitOptions& options) {
  const Fractal fractal(box.low, waves.lengths, amplitude, seed);
  normals::BaseMasks masks;
  MovesOfVisit moves(options);
  with_real(store, [&]<class Real>(Real) {
    using Point = Vector3<Real>;
    visit_vertices(store, options, std::tuple{rings_of<Point>("position"), overwrites<Point>(into)},
                   [&](const VertexRun& run, const VertexRings<Point>& ring, std::span<Point> to) {
                     for (std::size_t i = 0; i < run.count; ++i) {
                       const Wide at = widen(ring.vertex(i));
                       const Wide way =
                           fractal.at(at) * widen(normals::at_vertex(run, ring, i, masks));
                       to[i] = narrow<Real>(at + way);
                       moves.add(run, widen(to[i]) - at, way);
                     }
                   });
  });
  return moves.sum();
}

PLAIT_END_NAMESPACE
