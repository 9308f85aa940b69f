#include "generate/molecule_chain.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <optional>
#include <tuple>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace generation {
namespace {

constexpr double kStep = 3.8;           // between alpha carbons
constexpr double kLeastDistance = 4.8;  // between those that are not consecutive
constexpr double kBackboneRadius = 2.4;

/// The backbone so far, with a grid of cells that finds the atoms near a point.
class Backbone {
 public:
  explicit Backbone(double globule_radius) : globule_radius_(globule_radius) { push({0, 0, 0}); }

  const std::vector<Vector3<double>>& places() const { return places_; }

  /// Adds one atom: the best of some random directions in which the atom does not touch the chain.
  /// Returns false if there is none.
  bool grow(Random& random) {
    constexpr int kTries = 16;
    std::optional<Vector3<double>> best;
    double best_score = 0;
    for (int attempt = 0; attempt < kTries; ++attempt) {
      const Vector3<double> place = places_.back() + kStep * random.direction();
      // Inside the globule all directions have the same chance. Outside it, directions towards the
      // globule are preferred.
      const double outside = std::sqrt(dot(place, place)) - globule_radius_;
      const double score = (outside > 0 ? outside : 0) + random.unit();
      if (best && score >= best_score) continue;
      if (!is_clear(place)) continue;
      best = place;
      best_score = score;
    }
    if (best) push(*best);
    return best.has_value();
  }

  /// When the chain has no free direction left, another chain begins on the surface of the globule,
  /// in touch with the atoms there.
  void begin_another(Random& random) {
    constexpr double kProbe = 0.5;
    const Vector3<double> outward = kProbe * random.direction();
    Vector3<double> place{0, 0, 0};
    for (Vector3<double> probe = place; dot(probe, probe) < farthest2_; probe = probe + outward)
      if (!is_clear(probe)) place = probe;
    do place = place + outward;
    while (!is_clear(place));
    push(place);
  }

 private:
  using Cell = std::tuple<int, int, int>;

  static Cell cell_of(Vector3<double> place) {
    return {static_cast<int>(std::floor(place.x / kLeastDistance)),
            static_cast<int>(std::floor(place.y / kLeastDistance)),
            static_cast<int>(std::floor(place.z / kLeastDistance))};
  }

  void push(Vector3<double> place) {
    cells_[cell_of(place)].push_back(places_.size());
    places_.push_back(place);
    farthest2_ = std::max(farthest2_, dot(place, place));
  }

  bool is_clear(Vector3<double> place) const {
    const auto [x, y, z] = cell_of(place);
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dz = -1; dz <= 1; ++dz) {
          const auto cell = cells_.find({x + dx, y + dy, z + dz});
          if (cell == cells_.end()) continue;
          for (const std::size_t other : cell->second) {
            const Vector3<double> apart = place - places_[other];
            if (other + 1 < places_.size() && dot(apart, apart) < kLeastDistance * kLeastDistance)
              return false;
          }
        }
      }
    }
    return true;
  }

  double globule_radius_;
  double farthest2_ = 0;  ///< squared distance from the origin
  std::vector<Vector3<double>> places_;
  std::map<Cell, std::vector<std::size_t>> cells_;
};

}  // namespace

std::vector<Atom> fold_chain(std::uint64_t count, Random& random) {
  constexpr double kAtomsPerResidue = 5;
  const double residues = std::ceil(static_cast<double>(count) / kAtomsPerResidue) + 1;
  // The globule is smaller than the residues need, so that the chain stays as compact as possible.
  Backbone backbone(0.45 * kLeastDistance * std::cbrt(residues));
  while (static_cast<double>(backbone.places().size()) < residues)
    if (!backbone.grow(random)) backbone.begin_another(random);

  std::vector<Atom> atoms;
  for (const Vector3<double>& place : backbone.places()) {
    if (atoms.size() == count) break;
    atoms.push_back({place, kBackboneRadius});
    Vector3<double> tip = place;
    const auto side_chain_length = static_cast<int>(9 * random.unit());
    for (int link = 0; link < side_chain_length && atoms.size() < count; ++link) {
      constexpr double kBond = 1.5;
      tip = tip + kBond * random.direction();
      atoms.push_back({tip, random.between(1.4, 1.9)});
    }
  }
  return atoms;
}

}  // namespace generation
PLAIT_END_NAMESPACE
