// Compares every position and every normal of generated and real meshes with the naive oracle in
// double.
#include "kernels/oracle.h"

#include <fmt/format.h>

#include <vector>

#include "acceptance/meshes.h"
#include "acceptance/normal_bound.h"
#include "plait/digest.h"

using namespace plait;
using namespace plait::test;

namespace {

Store refine(const IndexedMesh& mesh, int levels, ExecutorKind executor) {
  StoreOptions options;
  options.backend = "memory";
  options.budget_bytes = std::uint64_t{4} << 30;
  Store store = Store::create({}, BaseMesh::build(mesh), options, default_backends());
  add_base_positions(store);
  SubdivideOptions what;
  what.levels = levels;
  what.executor = executor;
  what.normals = true;
  what.threads = 2;
  subdivide(store, what);
  return store;
}

/// Calls compare(oracle vertex, record) once for every vertex. Returns the number of vertices.
template <class Compare>
std::uint64_t for_each_vertex_once(Store& store, const std::string& attribute,
                                   const naive::Mesh& oracle, Compare compare) {
  std::vector<bool> seen(oracle.points.size(), false);
  std::uint64_t count = 0;
  for_each_vertex<Vector3<float>>(store, attribute, oracle,
                                  [&](naive::Index vertex, const Vector3<float>& record) {
                                    if (seen[vertex]) return;
                                    seen[vertex] = true;
                                    ++count;
                                    compare(vertex, point_of(record));
                                  });
  return count;
}

struct NormalFigures {
  std::uint64_t compared = 0, out_of_bounds = 0, of_wrong_length = 0, without_oracle = 0;
  /// Normals with the bound pi, which any normal satisfies.
  std::uint64_t undetermined = 0;
  double worst_undetermined = 0;
  std::uint64_t well_shaped = 0;
  double sum_of_squares = 0, worst = 0, worst_of_bound = 0, worst_well_shaped_units = 0;

  double rms() const { return std::sqrt(sum_of_squares / static_cast<double>(compared)); }
  double well_shaped_share() const {
    return static_cast<double>(well_shaped) / static_cast<double>(compared);
  }
  std::string text() const {
    return fmt::format(
        "normals: rms {:.2e} rad, worst {:.2e} rad and {:.3f} of its bound; {:.2f} % well shaped, "
        "at most {:.1f} units over the shortest edge; {} undetermined, worst {:.2e} rad; {} "
        "without a normal in double",
        rms(), worst, worst_of_bound, 100 * well_shaped_share(), worst_well_shaped_units,
        undetermined, worst_undetermined, without_oracle);
  }
};

NormalFigures compare_normals(Store& store, const naive::Mesh& oracle) {
  /// Twice the condition of a regular vertex with equilateral triangles.
  constexpr double kWellShaped = 5;
  const std::vector<naive::Point> expected = naive::loop_limit_normals(oracle);
  NormalBounds bounds(oracle);
  NormalFigures figures;
  const std::uint64_t count = for_each_vertex_once(
      store, "normal", oracle, [&](naive::Index vertex, const naive::Point& found) {
        if (naive::length(expected[vertex]) < 0.5) {
          ++figures.without_oracle;
          return;
        }
        const NormalBound bound = bounds.at(vertex);
        const double angle = naive::angle_between(expected[vertex], found);
        ++figures.compared;
        figures.of_wrong_length += !(std::abs(naive::length(found) - 1) < 1e-6);
        figures.out_of_bounds += !(angle <= bound.angle);
        figures.sum_of_squares += angle * angle;
        if (!bound.is_determined()) {
          ++figures.undetermined;
          figures.worst_undetermined = std::max(figures.worst_undetermined, angle);
          return;
        }
        figures.worst = std::max(figures.worst, angle);
        figures.worst_of_bound = std::max(figures.worst_of_bound, angle / bound.angle);
        if (bound.condition > kWellShaped) return;
        ++figures.well_shaped;
        figures.worst_well_shaped_units =
            std::max(figures.worst_well_shaped_units, angle * bound.shortest_edge / bounds.unit());
      });
  REQUIRE(count == oracle.points.size());
  return figures;
}

void check_against_oracle(const AcceptanceMesh& named, int levels) {
  INFO(named.name);
  const IndexedMesh mesh = named.make();
  Store store = refine(mesh, levels, ExecutorKind::kFused);
  const naive::Mesh oracle = naive::subdivide(to_naive(mesh), naive::Scheme::kLoop, levels);

  double worst = 0;
  const std::uint64_t count = for_each_vertex_once(
      store, "position", oracle, [&](naive::Index vertex, const naive::Point& found) {
        const double distance = naive::length(found - oracle.points[vertex]);
        worst = std::isnan(distance) ? INFINITY : std::max(worst, distance);
      });
  REQUIRE(count == oracle.points.size());
  worst /= bounding_box_diagonal(oracle.points);
  CHECK(worst < 1e-6);

  const NormalFigures normals = compare_normals(store, oracle);
  WARN(fmt::format("{}: {} vertices, positions within {:.2e} of the diagonal; {}", named.name,
                   count, worst, normals.text()));
  CHECK(normals.out_of_bounds == 0);
  CHECK(normals.of_wrong_length == 0);
  CHECK(normals.without_oracle == 0);
  CHECK(normals.rms() < 1e-4);
  // The bound is for the worst case. With well shaped triangles, the error is only a few units
  // divided by the shortest edge, and nearly all triangles are well shaped.
  CHECK(normals.worst_well_shaped_units < 4);
  CHECK(normals.well_shaped_share() > 0.998);
  // A bound of pi must be rare.
  CHECK(static_cast<double>(normals.undetermined) < 2e-4 * static_cast<double>(count));

  // Executors that give the same bits need no comparison with the oracle.
  const std::string expected = digest(store).to_string();
  for (const ExecutorKind executor : {ExecutorKind::kSweep, ExecutorKind::kTransparent}) {
    Store other = refine(mesh, levels, executor);
    CHECK(digest(other).to_string() == expected);
  }
}

}  // namespace

TEST_CASE("LoopOnGeneratedMeshes_PositionsAndNormals_AgreeWithTheOracle") {
  for (const AcceptanceMesh& mesh : generated_meshes(is_full_run() ? 26'016 : 3000))
    check_against_oracle(mesh, 4);
}

TEST_CASE("LoopOnRealMeshes_PositionsAndNormals_AgreeWithTheOracle", "[real-meshes]") {
  for (const AcceptanceMesh& mesh : real_meshes())
    check_against_oracle(mesh, is_full_run() ? 4 : 2);
}
