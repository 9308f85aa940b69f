#include "mesh/narrowing.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>

#include "base/interruption.h"
#include "mesh/parallel_parts.h"
#include "mesh/position_table.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

[[gnu::noipa]] double as_float32(double number) { return double{static_cast<float>(number)}; }

Vector3<double> float32_position(const Vector3<double>& p) {
  return {as_float32(p.x), as_float32(p.y), as_float32(p.z)};
}

bool is_finite_position(const Vector3<double>& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

double edge_length(const Vector3<double>& a, const Vector3<double>& b) {
  const Vector3<double> difference = a - b;
  return std::sqrt(dot(difference, difference));
}

namespace {

bool fit_all(std::span<const Vector3<double>> positions) {
  std::atomic<bool> fit = true;
  for_parts(positions.size(), [&](std::size_t first, std::size_t last, std::size_t) {
    for (std::size_t vertex = first; vertex < last && fit; ++vertex)
      if (is_finite_position(positions[vertex]) &&
          !(float32_position(positions[vertex]) == positions[vertex]))
        fit = false;
  });
  return fit;
}

std::vector<EdgesOfVertex> edges_of_vertices(std::span<const Vector3<double>> positions,
                                             std::span<const std::array<VertexId, 3>> faces) {
  std::vector<EdgesOfVertex> edges(positions.size());
  for (const std::array<VertexId, 3>& face : faces)
    for (std::size_t side = 0; side < 3; ++side) {
      const VertexId a = face[side], b = face[(side + 1) % 3];
      if (a >= positions.size() || b >= positions.size()) continue;  // refused elsewhere
      const double length = edge_length(positions[a], positions[b]);
      edges[a].add(length);
      edges[b].add(length);
    }
  return edges;
}

/// The distance from `number` to the next one of float32 that is farther from 0. Near 0 it has no
/// lower bound that matters here.
double step_of_float32(double number) {
  const float size = std::fabs(static_cast<float>(number));
  return double{std::nextafter(size, std::numeric_limits<float>::infinity())} - double{size};
}

/// The farthest that float32 may move a vertex that is near `p`.
double farthest_move_near(const Vector3<double>& p) {
  const Vector3<double> steps = {step_of_float32(p.x), step_of_float32(p.y), step_of_float32(p.z)};
  return 0.5 * std::sqrt(dot(steps, steps));
}

void measure_finest_level(const Vector3<double>& p, const EdgesOfVertex& edges, Narrowing& result) {
  if (!is_finite_position(float32_position(p)) || !(edges.longest > 0)) return;
  const double finest = std::ldexp(edges.longest, -result.levels);
  if (!(farthest_move_near(p) > Narrowing::kMostOfFinestEdge * finest)) return;
  ++result.coarse;
  const double step = std::max({step_of_float32(p.x), step_of_float32(p.y), step_of_float32(p.z)});
  if (step <= result.largest_step) return;
  result.largest_step = step;
  result.finest_edge = finest;
}

std::string harm_text(const Narrowing& narrowing) {
  std::string text;
  const auto add = [&](const std::string& part) { text += text.empty() ? part : (" and " + part); };
  if (narrowing.moved > 0)
    add(fmt::format(
        "moves {} vertices by more than {} of the shortest edge there (at most {:.3g}, "
        "{:.3g} edges)",
        narrowing.moved, Narrowing::kMostOfEdge, narrowing.farthest, narrowing.share_of_edge));
  if (narrowing.merged > 0)
    add(fmt::format("gives {} vertices the positions of others", narrowing.merged));
  if (narrowing.outside > 0) add(fmt::format("has no number for {} vertices", narrowing.outside));
  if (narrowing.coarse > 0)
    add(fmt::format(
        "has steps of {:.3g} where edges are {:.3g} long at level {} (around {} "
        "vertices)",
        narrowing.largest_step, narrowing.finest_edge, narrowing.levels, narrowing.coarse));
  return text;
}

}  // namespace

double lost_step(std::span<const Vector3<double>> positions, double edge) {
  constexpr double kMostOfEdge = 0.1, kFewestOfVertices = 0.1;
  if (!(edge > 0) || !fit_all(positions)) return 0;
  std::size_t count = 0;
  double largest = 0;
  for (std::size_t vertex = 0; vertex < positions.size(); ++vertex) {
    if (is_turn_to_poll(vertex)) poll_interruption();
    if (!is_finite_position(positions[vertex])) continue;
    double lost = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const auto number = static_cast<float>(positions[vertex][axis]);
      const double step = step_of_float32(positions[vertex][axis]);
      if ((std::bit_cast<std::uint32_t>(number) & 1u) != 0 && step > kMostOfEdge * edge)
        lost = std::max(lost, step);
    }
    count += lost > 0 ? 1u : 0u;
    largest = std::max(largest, lost);
  }
  return static_cast<double>(count) > kFewestOfVertices * static_cast<double>(positions.size())
             ? largest
             : 0;
}

void add_vertex(const Vector3<double>& position, const EdgesOfVertex& edges, Narrowing& result) {
  if (result.levels > 0) measure_finest_level(position, edges, result);
  if (!is_finite_position(position)) return;
  const Vector3<double> narrow = float32_position(position);
  if (narrow == position) return;
  if (!is_finite_position(narrow)) {
    ++result.outside;
    return;
  }
  const double move = edge_length(narrow, position);
  result.farthest = std::max(result.farthest, move);
  result.share_of_edge = std::max(result.share_of_edge, move / edges.shortest);
  if (move > Narrowing::kMostOfEdge * edges.shortest) ++result.moved;
}

Narrowing narrowing_of(std::span<const Vector3<double>> positions,
                       std::span<const std::array<VertexId, 3>> faces, int levels) {
  Narrowing result;
  result.levels = levels;
  const bool fit = fit_all(positions);
  if (fit && levels == 0) return result;
  const std::vector<EdgesOfVertex> edges = edges_of_vertices(positions, faces);
  for (VertexId vertex = 0; vertex < positions.size(); ++vertex)
    add_vertex(positions[vertex], edges[vertex], result);
  if (fit) return result;
  std::vector<Vector3<double>> narrow(positions.size());
  PositionTable vertices(narrow);
  for (VertexId vertex = 0; vertex < positions.size(); ++vertex) {
    if (is_turn_to_poll(vertex)) poll_interruption();
    narrow[vertex] = float32_position(positions[vertex]);
    if (!is_finite_position(narrow[vertex])) continue;
    const VertexId first = vertices.find_or_add(narrow[vertex], vertex);
    if (first != vertex && !(positions[first] == positions[vertex])) ++result.merged;
  }
  return result;
}

ComponentType precision_for(const Narrowing& narrowing, std::optional<ComponentType> asked,
                            std::string_view source, std::vector<std::string>& warnings) {
  if (!narrowing.harms()) return ComponentType::kFloat32;
  if (asked) {
    const std::string harm =
        fmt::format("{}: float32 {}: precision float64, or auto, keeps the positions", source,
                    harm_text(narrowing));
    if (narrowing.outside > 0) throw Error(ErrorCode::kInvalidArgument, harm);
    warnings.push_back(harm);
    return ComponentType::kFloat32;
  }
  warnings.push_back(
      fmt::format("{}: positions are float64, because float32 {}", source, harm_text(narrowing)));
  return ComponentType::kFloat64;
}

ComponentType precision_for(std::span<const Vector3<double>> positions,
                            std::span<const std::array<VertexId, 3>> faces, int levels,
                            std::optional<ComponentType> asked, std::string_view source,
                            std::vector<std::string>& warnings) {
  if (asked && *asked != ComponentType::kFloat32) return *asked;
  return precision_for(narrowing_of(positions, faces, levels), asked, source, warnings);
}

ComponentType precision_for(const IndexedMesh& mesh, int levels, std::optional<ComponentType> asked,
                            std::optional<ComponentType> of_file, std::string_view source,
                            std::vector<std::string>& warnings) {
  if (!asked && of_file == ComponentType::kFloat64) return ComponentType::kFloat64;
  return precision_for(mesh.positions, mesh.faces, levels, asked, source, warnings);
}

PLAIT_END_NAMESPACE
