#include "mesh/weld.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numeric>
#include <unordered_map>

#include "base/interruption.h"
#include "mesh/position_table.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

bool is_placed(const Vector3<double>& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

/// Cells as wide as the tolerance. A vertex within the tolerance is in one of the 27 cells around.
class CellGrid {
 public:
  CellGrid(const std::vector<Vector3<double>>& positions, double width)
      : positions_(positions), width_(width), next_(positions.size(), kNoId) {}

  /// The nearest vertex of the grid at most `width` away, of several the first; or kNoId.
  VertexId nearest(VertexId vertex) const {
    const Vector3<double>& at = positions_[vertex];
    const Cell cell = cell_of(at);
    VertexId found = kNoId;
    double least = width_ * width_;
    for (int number = 0; number < 27; ++number) {
      const int row = number / 3, layer = number / 9;
      const Cell near = {cell[0] + number % 3 - 1, cell[1] + row % 3 - 1, cell[2] + layer - 1};
      const auto first = first_.find(near);
      if (first == first_.end()) continue;
      for (VertexId other = first->second; other != kNoId; other = next_[other]) {
        const Vector3<double> way = positions_[other] - at;
        const double squared = dot(way, way);
        if (squared > least || (squared == least && found != kNoId && found < other)) continue;
        found = other;
        least = squared;
      }
    }
    return found;
  }

  void add(VertexId vertex) {
    VertexId& first = first_.try_emplace(cell_of(positions_[vertex]), kNoId).first->second;
    next_[vertex] = first;
    first = vertex;
  }

 private:
  using Cell = std::array<double, 3>;  // whole numbers, which may be beyond those of 64 bits
  struct CellHash {
    std::size_t operator()(const Cell& cell) const {
      std::size_t value = 0;
      for (const double number : cell)
        value = (value ^ std::hash<double>()(number)) * 0x9e3779b97f4a7c15u;
      return value ^ (value >> 32);
    }
  };

  Cell cell_of(const Vector3<double>& at) const {
    return {std::floor(at.x / width_), std::floor(at.y / width_), std::floor(at.z / width_)};
  }

  const std::vector<Vector3<double>>& positions_;
  double width_;
  std::unordered_map<Cell, VertexId, CellHash> first_;
  std::vector<VertexId> next_;  ///< [vertex] of the same cell
};

/// [vertex] what it becomes.
std::vector<VertexId> welded_vertices(const std::vector<Vector3<double>>& positions,
                                      double tolerance) {
  std::vector<VertexId> becomes(positions.size());
  PositionTable equal(positions);
  CellGrid near(positions, tolerance > 0 ? tolerance : 1);
  for (VertexId vertex = 0; vertex < positions.size(); ++vertex) {
    if (is_turn_to_poll(vertex)) poll_interruption();
    becomes[vertex] = vertex;
    if (!is_placed(positions[vertex])) continue;
    const VertexId first = equal.find_or_add(positions[vertex], vertex);
    if (first != vertex) {
      becomes[vertex] = becomes[first];
    } else if (tolerance > 0) {
      const VertexId other = near.nearest(vertex);
      if (other == kNoId)
        near.add(vertex);
      else
        becomes[vertex] = other;
    }
  }
  return becomes;
}

std::uint64_t other_records(const MeshAttribute& attribute, std::span<const VertexId> becomes) {
  const std::size_t bytes = attribute.schema.record_bytes();
  std::uint64_t count = 0;
  for (std::size_t vertex = 0; vertex < becomes.size(); ++vertex)
    if (becomes[vertex] != vertex &&
        std::memcmp(attribute.records.data() + vertex * bytes,
                    attribute.records.data() + becomes[vertex] * bytes, bytes) != 0)
      ++count;
  return count;
}

/// Keeps the vertices that become themselves.
void remove_others(AttributedMesh& read, std::span<const VertexId> becomes) {
  std::vector<VertexId> number(becomes.size());
  VertexId kept = 0;
  for (std::size_t vertex = 0; vertex < becomes.size(); ++vertex) {
    if (becomes[vertex] != vertex) {
      number[vertex] = number[becomes[vertex]];
      continue;
    }
    read.mesh.positions[kept] = read.mesh.positions[vertex];
    for (MeshAttribute& attribute : read.attributes) {
      const std::size_t bytes = attribute.schema.record_bytes();
      std::memmove(attribute.records.data() + kept * bytes,
                   attribute.records.data() + vertex * bytes, bytes);
    }
    number[vertex] = kept++;
  }
  read.mesh.positions.resize(kept);
  for (MeshAttribute& attribute : read.attributes)
    attribute.records.resize(kept * attribute.schema.record_bytes());
  for (std::array<VertexId, 3>& face : read.mesh.faces)
    for (VertexId& vertex : face) vertex = vertex < number.size() ? number[vertex] : vertex;
}

}  // namespace

std::uint64_t coinciding_vertices(const std::vector<Vector3<double>>& positions,
                                  std::span<const VertexId> vertices) {
  PositionTable table(positions);
  std::vector<bool> counted(positions.size(), false);
  std::uint64_t count = 0;
  std::uint64_t turn = 0;
  for (const VertexId vertex : vertices) {
    if (is_turn_to_poll(++turn)) poll_interruption();
    if (!is_placed(positions[vertex])) continue;
    const VertexId first = table.find_or_add(positions[vertex], vertex);
    if (first == vertex) continue;
    count += counted[first] ? 1u : 2u;
    counted[first] = true;
  }
  return count;
}

std::uint64_t seam_vertices_of(const BaseMesh& mesh) {
  std::vector<VertexId> on_border;
  for (const EdgeId edge : mesh.border_edges()) {
    on_border.push_back(mesh.edges()[edge].start);
    on_border.push_back(mesh.edges()[edge].end);
  }
  std::ranges::sort(on_border);
  on_border.erase(std::unique(on_border.begin(), on_border.end()), on_border.end());
  std::vector<Vector3<double>> positions;
  positions.reserve(on_border.size());
  for (const VertexId vertex : on_border) positions.push_back(mesh.positions()[vertex]);
  std::iota(on_border.begin(), on_border.end(), VertexId{0});
  return coinciding_vertices(positions, on_border);
}

std::string seam_text(std::uint64_t vertices, std::string_view remedy) {
  if (vertices == 0) return {};
  return fmt::format(
      "{} vertices have positions that others have: seams, where the surface is open ({})",
      vertices, remedy);
}

std::uint64_t weld(AttributedMesh& read, double tolerance, std::string_view source,
                   std::vector<std::string>& warnings) {
  if (!(tolerance >= 0) || !std::isfinite(tolerance))
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("{}: weld: expected a tolerance of 0 or more, found {}", source, tolerance));
  const std::vector<VertexId> becomes = welded_vertices(read.mesh.positions, tolerance);
  std::uint64_t merged = 0;
  for (std::size_t vertex = 0; vertex < becomes.size(); ++vertex)
    merged += becomes[vertex] != vertex ? 1u : 0u;
  if (merged == 0) return 0;
  warnings.push_back(fmt::format(
      "{}: {} vertices became others {} (weld)", source, merged,
      tolerance > 0 ? fmt::format("at most {} away", tolerance) : "of the same position"));
  for (const MeshAttribute& attribute : read.attributes)
    if (const std::uint64_t others = other_records(attribute, becomes); others > 0)
      warnings.push_back(fmt::format(
          "{}: attribute '{}': {} of the vertices that became others had another value, which is "
          "left out",
          source, attribute.schema.name, others));
  remove_others(read, becomes);
  return merged;
}

PLAIT_END_NAMESPACE
