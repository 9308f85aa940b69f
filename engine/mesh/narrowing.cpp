#include "mesh/narrowing.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "mesh/parallel_parts.h"
#include "mesh/position_table.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

[[gnu::noipa]] double as_float32(double number) { return double{static_cast<float>(number)}; }

namespace {

Vector3<double> as_floats(const Vector3<double>& p) {
  return {as_float32(p.x), as_float32(p.y), as_float32(p.z)};
}

bool has_finite_numbers(const Vector3<double>& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

double distance(const Vector3<double>& a, const Vector3<double>& b) {
  const Vector3<double> difference = a - b;
  return std::sqrt(dot(difference, difference));
}

bool fit_all(std::span<const Vector3<double>> positions) {
  std::atomic<bool> fit = true;
  for_parts(positions.size(), [&](std::size_t first, std::size_t last, std::size_t) {
    for (std::size_t vertex = first; vertex < last && fit; ++vertex)
      if (has_finite_numbers(positions[vertex]) &&
          !(as_floats(positions[vertex]) == positions[vertex]))
        fit = false;
  });
  return fit;
}

std::vector<double> shortest_edges(std::span<const Vector3<double>> positions,
                                   std::span<const std::array<VertexId, 3>> faces) {
  std::vector<double> shortest(positions.size(), std::numeric_limits<double>::infinity());
  for (const std::array<VertexId, 3>& face : faces)
    for (std::size_t side = 0; side < 3; ++side) {
      const VertexId a = face[side], b = face[(side + 1) % 3];
      if (a >= positions.size() || b >= positions.size()) continue;  // refused elsewhere
      const double length = distance(positions[a], positions[b]);
      if (!(length > 0)) continue;
      shortest[a] = std::min(shortest[a], length);
      shortest[b] = std::min(shortest[b], length);
    }
  return shortest;
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
  return text;
}

}  // namespace

Narrowing narrowing_of(std::span<const Vector3<double>> positions,
                       std::span<const std::array<VertexId, 3>> faces) {
  Narrowing result;
  if (fit_all(positions)) return result;
  const std::vector<double> shortest = shortest_edges(positions, faces);
  std::vector<Vector3<double>> narrow(positions.size());
  PositionTable vertices(narrow);
  for (VertexId vertex = 0; vertex < positions.size(); ++vertex) {
    narrow[vertex] = as_floats(positions[vertex]);
    if (!has_finite_numbers(positions[vertex])) continue;
    if (!has_finite_numbers(narrow[vertex])) {
      ++result.outside;
      continue;
    }
    const double move = distance(narrow[vertex], positions[vertex]);
    result.farthest = std::max(result.farthest, move);
    result.share_of_edge = std::max(result.share_of_edge, move / shortest[vertex]);
    if (move > Narrowing::kMostOfEdge * shortest[vertex]) ++result.moved;
    const VertexId first = vertices.find_or_add(narrow[vertex], vertex);
    if (first != vertex && !(positions[first] == positions[vertex])) ++result.merged;
  }
  return result;
}

ComponentType precision_for(std::span<const Vector3<double>> positions,
                            std::span<const std::array<VertexId, 3>> faces,
                            std::optional<ComponentType> asked, std::string_view source,
                            std::vector<std::string>& warnings) {
  if (asked && *asked != ComponentType::kFloat32) return *asked;
  const Narrowing narrowing = narrowing_of(positions, faces);
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

ComponentType precision_for(const IndexedMesh& mesh, std::optional<ComponentType> asked,
                            std::optional<ComponentType> of_file, std::string_view source,
                            std::vector<std::string>& warnings) {
  if (!asked && of_file == ComponentType::kFloat64) return ComponentType::kFloat64;
  return precision_for(mesh.positions, mesh.faces, asked, source, warnings);
}

PLAIT_END_NAMESPACE
