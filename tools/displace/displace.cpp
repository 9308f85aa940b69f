#include "displace/displace.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <tuple>
#include <utility>

#include "base/default_arithmetic.h"
#include "base/text.h"
#include "displace/gradient_noise.h"
#include "normals/ring_normal.h"
#include "passes/noise.h"
#include "passes/position_box.h"
#include "passes/vertex_noise.h"
#include "plait/error.h"
#include "plait/extend/store_access.h"
#include "plait/progress.h"
#include "plait/visit_vertices.h"

namespace plait {
namespace {

using Wide = Vector3<double>;
using Normal = Vector3<float>;

constexpr double kFirstWavelength = 0.125;  // of the diagonal
constexpr double kShortestWavelength = 4;   // of the mean edge
constexpr double kNextAmplitude = 0.45;     // of the one before

[[noreturn]] void refuse_displacement(const std::string& what) {
  throw Error(ErrorCode::kInvalidArgument, "displace: " + what);
}

/// The values of one thread, in a cache line of their own.
struct alignas(64) Measure {
  std::uint64_t lengths = 0, count = 0;
  double longest = 0;
};

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

template <class Real>
class Displacement {
  using Point = Vector3<Real>;

 public:
  Displacement(Store& store, const DisplaceOptions& options)
      : store_(store),
        options_(options),
        position_(store.attribute("position")),
        has_normals_(store.has_attribute("normal")),
        measures_(static_cast<std::size_t>(options.threads)) {
    visit_options_.threads = options.threads;
    passes_ = 2 + (options.kind == DisplacementKind::kFractal ? 1u : 0u) + (has_normals_ ? 1u : 0u);
  }

  Displaced run() {
    measure_box();
    if (has_normals_) check_budget();
    const bool is_fractal = options_.kind == DisplacementKind::kFractal;
    if (is_fractal) measure_edges();
    const AttributeId moved = StoreAccess::add_replacement(store_, schema_of<Point>("position"));
    while (store_.attributes()[moved].finest_level < store_.attributes()[position_].finest_level)
      store_.add_level(moved);
    moved_ = store_.attributes()[moved].schema.name;
    is_fractal ? add_fractal() : add_noise();
    StoreAccess::name_replacement(store_, moved);
    Provenance provenance = store_.provenance();
    provenance.scheme.clear();
    provenance.limit = false;
    provenance.program = program_version();
    StoreAccess::set_provenance(store_, provenance);
    if (has_normals_) make_normals();
    for (const Measure& measure : measures_)
      displaced_.largest_move = std::max(displaced_.largest_move, measure.longest);
    return displaced_;
  }

 private:
  const VisitOptions& pass(std::string_view phase) {
    visit_options_.name = fmt::format("displace: {}", phase);
    if (options_.progress)
      visit_options_.progress = [this, phase, before = passes_done_++](const Progress& now) {
        return options_.progress({phase, before * now.total + now.done, passes_ * now.total});
      };
    return visit_options_;
  }
  Measure& measure_of(const VertexRun& run) {
    return measures_[static_cast<std::size_t>(run.worker)];
  }

  void measure_box() {
    const PositionBox all = measure_positions<Real>(store_, pass("bounding box"));
    if (!all.finite) refuse_displacement("a position of the store is not finite");
    low_ = all.low;
    displaced_.diagonal = all.diagonal();
    if (!all.has_extent())
      refuse_displacement(
          "the bounding box of the positions has no extent, or none that a number can hold");
  }

  /// The pass that makes the normals is the last one; the other passes check their own need.
  void check_budget() {
    const Needs needs =
        visit_needs(store_, visit_options_,
                    std::tuple{rings_of<Point>("position"), overwrites<Normal>("normal")});
    if (needs.frames > StoreAccess::pager(store_).budget_bytes())
      throw Error(ErrorCode::kBudget,
                  fmt::format("displace: the budget is {} bytes, new normals need {}",
                              StoreAccess::pager(store_).budget_bytes(), needs.frames));
  }

  /// Lengths are added as whole numbers, so that the sum does not depend on threads: 2^32 is the
  /// diagonal. Every edge is added twice, once at each end.
  void measure_edges() {
    const double unit = 0x1p32 / displaced_.diagonal;
    visit_vertices(store_, pass("mean edge"), std::tuple{rings_of<Point>("position")},
                   [&](const VertexRun& run, const VertexRings<Point>& ring) {
                     Measure& measure = measure_of(run);
                     for (std::size_t i = 0; i < run.count; ++i)
                       for (int k = 0; k < ring.valence(); ++k) {
                         const Wide edge = widen(ring.neighbour(i, k)) - widen(ring.vertex(i));
                         const double length = std::sqrt(dot(edge, edge));
                         measure.lengths += static_cast<std::uint64_t>(std::llround(length * unit));
                         ++measure.count;
                       }
                   });
    std::uint64_t lengths = 0, count = 0;
    for (const Measure& measure : measures_) {
      lengths += measure.lengths;
      count += measure.count;
    }
    displaced_.mean_edge = static_cast<double>(lengths) / unit / static_cast<double>(count);
    const double shortest = kShortestWavelength * displaced_.mean_edge;
    // A mean edge of 2^-32 diagonals or less counts as 0. Then the octaves end by their number.
    constexpr std::size_t kMostOctaves = 32;
    for (double wavelength = kFirstWavelength * displaced_.diagonal;
         wavelength >= shortest && displaced_.wavelengths.size() < kMostOctaves; wavelength /= 2)
      displaced_.wavelengths.push_back(wavelength);
    if (displaced_.wavelengths.empty())
      refuse_displacement(
          fmt::format("fractal: the mean edge is {:.3g} and the diagonal {:.3g}; the first wave "
                      "is an eighth of the diagonal, and needs edges of a thirty-second at most: "
                      "refine the mesh further",
                      displaced_.mean_edge, displaced_.diagonal));
  }

  void add_noise() {
    const Noise noise{store_.base().edges(), options_.amplitude * displaced_.diagonal,
                      options_.seed};
    visit_vertices(
        store_, pass("noise"), std::tuple{reads<Point>("position"), overwrites<Point>(moved_)},
        [&](const VertexRun& run, std::span<const Point> from, std::span<Point> to) {
          Measure& measure = measure_of(run);
          noise.for_each(
              run, [&](std::size_t i, const Wide& way) { to[i] = moved(measure, from[i], way); });
        });
  }

  void add_fractal() {
    const Fractal fractal(low_, displaced_.wavelengths, options_.amplitude * displaced_.diagonal,
                          options_.seed);
    visit_vertices(
        store_, pass("fractal"), std::tuple{rings_of<Point>("position"), overwrites<Point>(moved_)},
        [&](const VertexRun& run, const VertexRings<Point>& ring, std::span<Point> to) {
          Measure& measure = measure_of(run);
          for (std::size_t i = 0; i < run.count; ++i) {
            const Wide normal = widen(normals::at_vertex(run, ring, i, masks_));
            to[i] = moved(measure, ring.vertex(i), fractal.at(widen(ring.vertex(i))) * normal);
          }
        });
  }

  void make_normals() {
    visit_vertices(store_, pass("normals"),
                   std::tuple{rings_of<Point>("position"), overwrites<Normal>("normal")},
                   [&](const VertexRun& run, const VertexRings<Point>& ring, std::span<Normal> to) {
                     for (std::size_t i = 0; i < run.count; ++i)
                       to[i] = normals::at_vertex(run, ring, i, masks_);
                   });
    StoreAccess::set_rounding(store_, store_.attribute("normal"), {});
  }

  static Point moved(Measure& measure, const Point& from, const Wide& way) {
    measure.longest = std::max(measure.longest, std::sqrt(dot(way, way)));
    return narrow<Real>(widen(from) + way);
  }

  Store& store_;
  const DisplaceOptions& options_;
  AttributeId position_;
  std::string moved_;  ///< the attribute that becomes the position
  bool has_normals_;
  std::uint64_t passes_ = 0, passes_done_ = 0;
  VisitOptions visit_options_;
  std::vector<Measure> measures_;  ///< [worker]
  normals::BaseMasks masks_;
  Wide low_{};
  Displaced displaced_;
};

void check_displacement(const Store& store, const DisplaceOptions& options) {
  if (!(options.amplitude >= 0 && options.amplitude <= 1))
    refuse_displacement(
        fmt::format("amplitude {}, expected 0 to 1: it counts in diagonals of the bounding box",
                    options.amplitude));
  const AttributeInfo& position = store.attributes()[store.attribute("position")];
  if (position.schema.type == ComponentType::kFloat64)
    StoreAccess::check_type(store, store.attribute("position"), ComponentType::kFloat64, 3);
  else
    StoreAccess::check_type(store, store.attribute("position"), ComponentType::kFloat32, 3);
  if (!store.has_attribute("normal")) return;
  StoreAccess::check_type(store, store.attribute("normal"), ComponentType::kFloat32, 3);
  const int normal_levels = store.attributes()[store.attribute("normal")].finest_level;
  if (normal_levels != position.finest_level)
    refuse_displacement(
        fmt::format("attribute 'normal' has level {} and attribute 'position' has level {}",
                    normal_levels, position.finest_level));
}

constexpr NameTable<DisplacementKind, 2> kDisplacements("displacement",
                                                        {{DisplacementKind::kNoise, "noise"},
                                                         {DisplacementKind::kFractal, "fractal"}});

}  // namespace

std::string_view to_string(DisplacementKind kind) noexcept { return kDisplacements.name_of(kind); }

DisplacementKind displacement_from_name(std::string_view name) { return kDisplacements.find(name); }

Displaced displace(Store& store, const DisplaceOptions& wanted) try {
  const DefaultArithmetic arithmetic;
  DisplaceOptions options = wanted;
  options.threads = thread_count(wanted.threads, "displace");
  check_displacement(store, options);
  const AttributeInfo& position = store.attributes()[store.attribute("position")];
  if (position.schema.type == ComponentType::kFloat64)
    return Displacement<double>(store, options).run();
  return Displacement<float>(store, options).run();
} catch (const std::bad_alloc&) {
  throw out_of_memory("displace " + store.path().native());
}

}  // namespace plait
