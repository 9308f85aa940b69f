// How long does it take to find the faces in a box, or along a ray, compared with a loop over the
// bounds of all faces?
//
//   plait_bench_face_queries [--refinements 7] [--level 3] [--layouts hilbert,given]
//                            [--queries 2000] [--runs 5] [--directory .]
//
// The surface is a sphere of radius about one. Boxes are cubes around a vertex of it. Rays begin
// outside and go through a point near the centre. The floor tests the bounds of every face with the
// same formulas, and keeps the numbers of those that it finds. Queries and floor take turns; each
// must find as many faces as the other. Before them,
// the program measures the first query of a reader, which gets the bounds of all faces: without a
// file of bounds, and with one. The program prints Markdown tables of medians over the runs.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "micro/command_line.h"
#include "micro/support.h"
#include "plait/bounds.h"
#include "plait/layout.h"
#include "plait/reader.h"
#include "plait/registry.h"

namespace {

using namespace plait;
using namespace plait::bench;
namespace fs = std::filesystem;
using Point = Vector3<double>;

struct Settings {
  int refinements = 7, level = 3, queries = 2000, runs = 5;
  std::vector<std::string> layouts = {"hilbert", "given"};
  std::string directory = ".";
};

struct FaceBox {
  Vector3<float> low, high;
};

/// The bounds of all faces, from one vertex after another.
std::vector<FaceBox> bounds_of(const Reader& reader, std::uint64_t face_count, int level) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  std::vector<FaceBox> all(
      face_count, {{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}});
  std::vector<Vector3<float>> points(patch_vertex_count(std::int64_t{1} << level));
  for (FaceId face = 0; face < face_count; ++face) {
    reader.read_patch(face, level).attribute<Vector3<float>>("position").copy_to(points);
    for (const Vector3<float>& point : points)
      for (int axis = 0; axis < 3; ++axis) {
        all[face].low[axis] = std::min(all[face].low[axis], point[axis]);
        all[face].high[axis] = std::max(all[face].high[axis], point[axis]);
      }
  }
  return all;
}

bool meet(const FaceBox& a, const Box& b) {
  for (int axis = 0; axis < 3; ++axis)
    if (a.high[axis] < b.low[axis] || a.low[axis] > b.high[axis]) return false;
  return true;
}

bool meets_ray(const FaceBox& box, Point origin, Point direction) {
  double near = 0, far = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const bool forward = direction[axis] > 0;
    const double low = box.low[axis], high = box.high[axis];
    near = std::max(near, ((forward ? low : high) - origin[axis]) / direction[axis]);
    far = std::min(far, ((forward ? high : low) - origin[axis]) / direction[axis]);
  }
  return near <= far * (1 + 8 * std::numeric_limits<double>::epsilon());
}

struct Query {
  Box box;
  Point origin, direction;
};

struct Row {
  std::string layout, what;
  double side = 0;                            ///< of the box; 0: a ray
  std::vector<double> tree = {}, floor = {};  ///< microseconds of a query
  double found = 0;                           ///< faces of a query
};

std::vector<Query> make_queries(const std::vector<FaceBox>& bounds, double side, int count,
                                unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> near(-0.5, 0.5);
  std::vector<Query> queries;
  for (int at = 0; at < count; ++at) {
    const Vector3<float> corner = bounds[random() % bounds.size()].low;
    const Point centre = {corner.x, corner.y, corner.z};
    const Point half = {side / 2, side / 2, side / 2};
    const Point aim = {near(random), near(random), near(random)};
    queries.push_back({{centre - half, centre + half}, 3.0 * centre, aim - 3.0 * centre});
  }
  return queries;
}

void measure(Row& row, const Reader& reader, const std::vector<FaceBox>& bounds, int count,
             unsigned seed) {
  const std::vector<Query> queries = make_queries(bounds, row.side, count, seed);
  std::uint64_t found = 0, found_by_floor = 0;
  row.tree.push_back(1e6 / count * seconds([&] {
                       for (const Query& query : queries)
                         found +=
                             row.side > 0
                                 ? reader.faces_in_box(query.box).size()
                                 : reader.faces_along_ray(query.origin, query.direction).size();
                     }));
  // The loop takes long, so it has fewer queries.
  const auto fewer = std::span(queries).first(std::max<std::size_t>(1, queries.size() / 20));
  std::uint64_t found_of_fewer = 0;
  for (const Query& query : fewer)
    found_of_fewer += row.side > 0 ? reader.faces_in_box(query.box).size()
                                   : reader.faces_along_ray(query.origin, query.direction).size();
  row.floor.push_back(1e6 / static_cast<double>(fewer.size()) * seconds([&] {
                        for (const Query& query : fewer) {
                          std::vector<FaceId> faces;
                          for (FaceId face = 0; face < bounds.size(); ++face)
                            if (row.side > 0
                                    ? meet(bounds[face], query.box)
                                    : meets_ray(bounds[face], query.origin, query.direction))
                              faces.push_back(face);
                          found_by_floor += faces.size();
                        }
                      }));
  if (found_of_fewer != found_by_floor)
    throw Error(ErrorCode::kBadState,
                fmt::format("{} {}: found {} faces, the loop found {}", row.layout, row.what,
                            found_of_fewer, found_by_floor));
  row.found = static_cast<double>(found) / count;
}

int run(const Settings& settings) {
  const fs::path path = fs::path(settings.directory) / "plait-bench.plait";
  std::vector<Row> rows;
  std::vector<double> without_file, with_file;
  std::uint64_t face_count = 0;
  for (const std::string& layout : settings.layouts) {
    say_progress(fmt::format("{}: making a store", layout));
    fs::remove_all(path);
    {
      Store store =
          Store::create(path, lay_out(octahedron(settings.refinements), layout_from_name(layout)),
                        {}, default_backends());
      add_base_positions(store);
      subdivide(store, {.levels = settings.level});
      store.commit();
    }
    const Store store = Store::open(path, {}, default_backends());
    face_count = store.base().face_count();
    const auto first_query = [&] {
      const Reader reader(store);
      return seconds([&] { static_cast<void>(reader.faces_in_box({})); });
    };
    for (int turn = 0; turn < settings.runs; ++turn) without_file.push_back(first_query());
    write_bounds(store);
    for (int turn = 0; turn < settings.runs; ++turn) with_file.push_back(first_query());

    const Reader reader(store);
    const std::vector<FaceBox> bounds = bounds_of(reader, face_count, settings.level);
    static_cast<void>(reader.faces_in_box({}));
    const std::size_t first = rows.size();
    for (const double side : {0.02, 0.1, 0.5})
      rows.push_back({layout, fmt::format("box, side {}", side), side});
    rows.push_back({layout, "ray"});
    for (int turn = 0; turn < settings.runs; ++turn)
      for (std::size_t at = first; at < rows.size(); ++at) {
        say_progress(fmt::format("{}: run {} of {}", layout, turn + 1, settings.runs));
        measure(rows[at], reader, bounds, settings.queries, static_cast<unsigned>(turn));
      }
  }
  fs::remove_all(path);

  instrument::Table table =
      instrument::table_with("layout|query|#faces found|#us|#loop, us|#loop / query");
  for (const Row& row : rows)
    table.rows.push_back(
        {{row.layout, row.what, number(row.found, 1), spread(row.tree, 1, 1),
          middle(row.floor, 1, 0), number(*middle(row.floor).value / *middle(row.tree).value, 0)}});
  print_table(fmt::format("{} faces, level {}, {} queries, {} runs; first query of a reader: {} ms "
                          "without a file of bounds, {} ms with one",
                          face_count, settings.level, settings.queries, settings.runs,
                          middle(without_file, 1e3, 1).text, middle(with_file, 1e3, 1).text),
              table);
  return 0;
}

}  // namespace

int main(int count, char** words) {
  Settings settings;
  return run_program(
      "plait_bench_face_queries", "Faces in a box and along a ray", count, words,
      [&](CommandLine& app) {
        add_surface_options(app, settings.refinements, settings.level);
        app.add_option("--layouts", settings.layouts, "Orders of the faces, several with commas")
            ->delimiter(',');
        add_number_option(app, "--queries", settings.queries, 1, 100000000, "Queries of a run");
        add_runs_option(app, settings.runs);
        add_directory_option(app, settings.directory);
      },
      [&] { return run(settings); }, &settings.directory);
}
