#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

#include "generate/kinds.h"
#include "generate/marching_tetrahedra.h"
#include "generate/molecule_chain.h"
#include "generate/portable_math.h"
#include "generate/random.h"
#include "generate/reduce.h"
#include "generate/smoothing.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace generation {
namespace {

/// An atom adds exp(-B (d^2/r^2 - 1)) to the field, which is 1 on the atom's own surface. So the
/// surface of level 1 is near the van der Waals surface. A smaller B makes it rounder between
/// atoms.
constexpr double kSharpness = 1.0;
constexpr float kLevel = 1.0f;
/// The distance from which an atom adds less than 1e-4 of the level.
constexpr double kReach = 3.2;  // in radii

class GaussianField {
 public:
  explicit GaussianField(std::vector<Atom> atoms) : atoms_(std::move(atoms)) {
    std::sort(atoms_.begin(), atoms_.end(), [](const Atom& a, const Atom& b) {
      return a.centre.z - kReach * a.radius < b.centre.z - kReach * b.radius;
    });
    for (const Atom& atom : atoms_) {
      for (int axis = 0; axis < 3; ++axis) {
        const double reach = kReach * atom.radius;
        lowest_[axis] = std::min(lowest_[axis], atom.centre[axis] - reach);
        highest_[axis] = std::max(highest_[axis], atom.centre[axis] + reach);
      }
    }
  }

  /// The level set, on a grid that contains every atom with a margin.
  IndexedMesh surface(double spacing, const Progress& progress) const {
    const auto points = [&](int axis) {
      return static_cast<std::size_t>(std::ceil((highest_[axis] - lowest_[axis]) / spacing)) + 3;
    };
    const Vector3<double> margin{spacing, spacing, spacing};
    const Grid grid{lowest_ - margin, spacing, points(0), points(1), points(2)};
    std::vector<const Atom*> active;
    std::size_t next = 0;
    Profile along_x, along_y;
    return march_tetrahedra(
        grid, kLevel,
        [&](std::size_t z, std::span<float> values) {
          // Calls come in ascending z, so the atoms near a layer change little from one layer to
          // the next.
          const double height = grid.origin.z + spacing * static_cast<double>(z);
          std::erase_if(active, [height](const Atom* atom) {
            return atom->centre.z + kReach * atom->radius < height;
          });
          for (; next < atoms_.size(); ++next) {
            const Atom& atom = atoms_[next];
            if (atom.centre.z - kReach * atom.radius > height) break;
            active.push_back(&atom);
          }
          std::fill(values.begin(), values.end(), 0.0f);
          for (const Atom* atom : active) {
            make_profile(grid.origin.x, spacing, atom->centre.x, atom->radius, along_x);
            make_profile(grid.origin.y, spacing, atom->centre.y, atom->radius, along_y);
            const double distance = (height - atom->centre.z) / atom->radius;
            const auto factor_z =
                static_cast<float>(portable_exp(-kSharpness * (distance * distance - 1)));
            for (std::size_t y = 0; y < along_y.factors.size(); ++y) {
              const float factor_yz = factor_z * along_y.factors[y];
              float* row = values.data() + (along_y.begin + y) * grid.width + along_x.begin;
              for (std::size_t x = 0; x < along_x.factors.size(); ++x)
                row[x] += factor_yz * along_x.factors[x];
            }
          }
        },
        progress);
  }

  double surface_area_estimate() const { return 25.0 * static_cast<double>(atoms_.size()); }

 private:
  /// One factor of the Gaussian for each grid line that the atom reaches along one axis.
  struct Profile {
    std::size_t begin = 0;
    std::vector<float> factors;
  };
  static void make_profile(double origin, double spacing, double centre, double radius,
                           Profile& profile) {
    const double first = std::ceil((centre - kReach * radius - origin) / spacing);
    const double last = std::floor((centre + kReach * radius - origin) / spacing);
    profile.begin = static_cast<std::size_t>(first);
    profile.factors.clear();
    for (double point = first; point <= last; ++point) {
      const double distance = (origin + spacing * point - centre) / radius;
      profile.factors.push_back(
          static_cast<float>(portable_exp(-kSharpness * distance * distance)));
    }
  }

  std::vector<Atom> atoms_;
  Vector3<double> lowest_{1e300, 1e300, 1e300}, highest_{-1e300, -1e300, -1e300};
};

/// The component with the most vertices, the first one of equals. The order of vertices and faces
/// does not change.
IndexedMesh largest_component(IndexedMesh mesh) {
  std::vector<VertexId> root(mesh.positions.size());
  std::iota(root.begin(), root.end(), VertexId{0});
  const auto find = [&root](VertexId vertex) {
    while (root[vertex] != vertex) vertex = root[vertex] = root[root[vertex]];
    return vertex;
  };
  for (const auto& face : mesh.faces) {
    for (const std::size_t corner : {1u, 2u}) {
      const auto [low, high] = std::minmax({find(face[0]), find(face[corner])});
      root[high] = low;
    }
  }
  std::vector<std::uint32_t> size(root.size(), 0);
  for (VertexId vertex = 0; vertex < root.size(); ++vertex) ++size[find(vertex)];
  const auto largest =
      static_cast<VertexId>(std::max_element(size.begin(), size.end()) - size.begin());

  std::vector<VertexId> new_id(root.size(), kNoId);
  IndexedMesh component;
  for (VertexId vertex = 0; vertex < root.size(); ++vertex) {
    if (find(vertex) != largest) continue;
    new_id[vertex] = static_cast<VertexId>(component.positions.size());
    component.positions.push_back(mesh.positions[vertex]);
  }
  for (const auto& [a, b, c] : mesh.faces)
    if (new_id[a] != kNoId) component.faces.push_back({new_id[a], new_id[b], new_id[c]});
  return component;
}

/// A surface with 1.3 to 2 times as many vertices as wanted. The edge collapses that remove the
/// extra vertices improve the triangles, and the surface is small enough to be made fast.
IndexedMesh fine_surface(const GaussianField& field, std::uint64_t vertices,
                         const Progress& progress) {
  const auto wanted = static_cast<double>(vertices);
  constexpr double kLeast = 1.3, kAim = 1.55, kMost = 2.0;
  // The number of vertices grows with the inverse square of the spacing. A coarse surface gives the
  // factor, and the share of the largest component.
  constexpr double kProbeVertices = 20'000;
  const double probed = std::min(kAim * wanted, kProbeVertices);
  double spacing = std::sqrt(3 * field.surface_area_estimate() / probed);
  IndexedMesh surface;
  constexpr int kTries = 12;
  for (int attempt = 0; attempt < kTries; ++attempt) {
    surface = largest_component(field.surface(spacing, progress));
    const auto found = static_cast<double>(surface.positions.size());
    if (found >= kLeast * wanted && found <= kMost * wanted) break;
    spacing *= found > 0 ? std::sqrt(found / (kAim * wanted)) : 0.5;
  }
  return surface;
}

}  // namespace

IndexedMesh make_molecule(std::uint64_t vertices, std::uint64_t seed, const Progress& progress) {
  constexpr std::uint64_t kVerticesPerAtom = 24, kFewestAtoms = 6, kMostAtoms = 8000;
  const std::uint64_t atom_count =
      std::clamp(vertices / kVerticesPerAtom, kFewestAtoms, kMostAtoms);
  IndexedMesh mesh;
  // A small surface of high genus may have no triangulation with so few vertices. Then the loop
  // tries another fold of the chain.
  constexpr std::uint64_t kFolds = 16;
  for (std::uint64_t fold = 0; fold < kFolds; ++fold) {
    Random random(mix(seed) + fold);
    const GaussianField field(fold_chain(atom_count, random));
    mesh = fine_surface(field, vertices, progress.part(0, 0.4));
    constexpr int kTaubinSteps = 8;
    taubin_smooth(mesh, kTaubinSteps);
    mesh = reduce(std::move(mesh), {vertices, seed, 0}, progress.part(0.4, 0.95));
    if (mesh.positions.size() == vertices) break;
  }
  return mesh;
}

}  // namespace generation
PLAIT_END_NAMESPACE
