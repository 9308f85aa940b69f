// How long does it take to find the faces in a box, or along a ray, compared with a loop over the
// bounds of all faces?
//
//   plait_bench_face_queries [--refinements 7] [--level 3] [--layouts hilbert,given]
//                            [--queries 2000] [--runs 5] [--directory .]
//
// The surface is a sphere of radius about one. Boxes are cubes around a vertex of it. Rays begin
// outside and go through a point near the centre. The floor tests the bounds of every face with the
// same formulas, and keeps the numbers of those that it finds. Queries and floor take turns; each
// must find as many faces as the other. Before them, the program measures the first query of a
// reader, which gets the bounds of all faces: without a file of bounds, and with one. The program
// prints Markdown tables of medians over the runs.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "micro/command_line.h"
#include "micro/support.h"
#include "plait/bounds.h"
#include "plait/error.h"
#include "plait/reader.h"

namespace {

using namespace plait;
using namespace plait::bench;
using Point = Vector3<double>;

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

/// Faces found, microseconds of a query, and those of the loop. `side` is 0 for rays.
void measure(Measurements& table, const std::string& layout, double side, const Reader& reader,
             const std::vector<FaceBox>& bounds, int count, unsigned seed) {
  const std::vector<Query> queries = make_queries(bounds, side, count, seed);
  const auto find = [&](const Query& query) {
    return side > 0 ? reader.faces_in_box(query.box).size()
                    : reader.faces_along_ray(query.origin, query.direction).size();
  };
  std::uint64_t found = 0, found_of_fewer = 0, found_by_floor = 0;
  const double tree = 1e6 / count * seconds([&] {
                        for (const Query& query : queries) found += find(query);
                      });
  // The loop takes long, so it has fewer queries.
  const auto fewer = std::span(queries).first(std::max<std::size_t>(1, queries.size() / 20));
  for (const Query& query : fewer) found_of_fewer += find(query);
  const double floor = 1e6 / static_cast<double>(fewer.size()) * seconds([&] {
                         for (const Query& query : fewer) {
                           std::vector<FaceId> faces;
                           for (FaceId face = 0; face < bounds.size(); ++face)
                             if (side > 0 ? meet(bounds[face], query.box)
                                          : meets_ray(bounds[face], query.origin, query.direction))
                               faces.push_back(face);
                           found_by_floor += faces.size();
                         }
                       });
  const std::string what = side > 0 ? fmt::format("box, side {}", side) : "ray";
  if (found_of_fewer != found_by_floor)
    throw Error(ErrorCode::kBadState, fmt::format("{} {}: found {} faces, the loop found {}",
                                                  layout, what, found_of_fewer, found_by_floor));
  table.add({layout, what}, {static_cast<double>(found) / count, tree, floor, floor / tree});
}

void run(const Settings& settings) {
  Measurements table("layout|query",
                     {{"faces found", 1}, {"us", 1, true}, {"loop, us", 0}, {"loop / query", 0}});
  Measurements first_queries("first query of a reader", {{"ms", 1}});
  std::uint64_t face_count = 0;
  for (const std::string& layout : settings.layouts) {
    say_progress(fmt::format("{}: making a store", layout));
    const Store store = refined_store(
        settings.store(), mesh_or_octahedron({}, settings.refinements, layout_from_name(layout)),
        settings.level, {});
    face_count = store.base().face_count();
    for (const char* file : {"without a file of bounds", "with one"}) {
      for (int turn = 0; turn < settings.runs; ++turn) {
        const Reader reader(store);
        first_queries.add({file},
                          {1e3 * seconds([&] { static_cast<void>(reader.faces_in_box({})); })});
      }
      write_bounds(store);
    }
    const Reader reader(store);
    const std::vector<FaceBox> bounds = bounds_of(reader, face_count, settings.level);
    static_cast<void>(reader.faces_in_box({}));
    for (int turn = 0; turn < settings.runs; ++turn)
      for (const double side : {0.02, 0.1, 0.5, 0.0}) {
        say_progress(fmt::format("{}: run {} of {}", layout, turn + 1, settings.runs));
        measure(table, layout, side, reader, bounds, settings.queries, static_cast<unsigned>(turn));
      }
  }
  table.print(fmt::format("{} faces, level {}, {} queries, {} runs", face_count, settings.level,
                          settings.queries, settings.runs));
  first_queries.print("\nThe first query of a reader gets the bounds of all faces");
}

}  // namespace

int main(int count, char** words) {
  return Program("plait_bench_face_queries", "Faces in a box and along a ray",
                 {.refinements = 7, .level = 3},
                 {"--refinements", "--level", "--layouts", "--queries", "--runs", "--directory"})
      .run(count, words, run);
}
