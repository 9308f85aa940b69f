#include "mesh/connectivity.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

#include "base/interruption.h"
#include "mesh/parallel_parts.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Numbers edges by first use, face by face. is_first(face, side) tells whether no earlier face has
/// the edge. For each such side the function calls number(face, side, edge), in any order of faces.
/// Returns the number of edges.
template <class IsFirst, class Number>
EdgeId number_by_first_use(std::size_t face_count, IsFirst is_first, Number number) {
  std::vector<std::uint8_t> sides(face_count);  // [face] one bit per side that is first
  std::vector<EdgeId> before(part_count(face_count), 0);
  for_parts(face_count, [&](std::size_t first, std::size_t last, std::size_t part) {
    EdgeId edges = 0;
    for (std::size_t face = first; face < last; ++face)
      for (const int side : kSideOrder)
        if (is_first(static_cast<FaceId>(face), side)) {
          sides[face] = static_cast<std::uint8_t>(sides[face] | 1u << side);
          ++edges;
        }
    before[part] = edges;
  });
  EdgeId total = 0;
  for (EdgeId& edges : before) {
    const EdgeId of_part = edges;
    edges = total;
    total += of_part;
  }
  for_parts(face_count, [&](std::size_t first, std::size_t last, std::size_t part) {
    EdgeId edge = before[part];
    for (std::size_t face = first; face < last; ++face)
      for (const int side : kSideOrder)
        if ((sides[face] >> side & 1) != 0) number(static_cast<FaceId>(face), side, edge++);
  });
  return total;
}

auto& entry(auto&& table, FaceSide side) {
  return table[side.face()][static_cast<std::size_t>(side.side())];
}

/// The corner at the same vertex in the next face of its fan.
FaceSide next_corner(std::span<const SideCodes> twins, FaceSide corner) {
  const FaceSide beyond = from_code(entry(twins, FaceSide(corner.face(), (corner.side() + 1) % 3)));
  return beyond.exists() ? FaceSide(beyond.face(), (beyond.side() + 1) % 3) : FaceSide();
}

[[noreturn]] void refuse_fans(std::span<const FaceVertices> faces, std::span<const SideCodes> twins,
                              VertexId vertex, FaceSide first, const MeshSource& source) {
  std::set<std::uint64_t> all, of_fan;  // numbers of the file
  for (FaceId face = 0; face < faces.size(); ++face)
    if (std::ranges::find(faces[face], vertex) != faces[face].end()) all.insert(source.face(face));
  FaceSide corner = first;
  do {
    of_fan.insert(source.face(corner.face()));
    corner = next_corner(twins, corner);
  } while (corner.exists() && corner != first);
  throw more_than_one_fan(source.name(), vertex, all.size(), of_fan.size(),
                          source.face(first.face()));
}

}  // namespace

Error too_many_faces_at_edge(std::string_view source, VertexId low, VertexId high,
                             std::span<const std::uint64_t, 3> first_faces, std::uint64_t count) {
  return {ErrorCode::kInvalidArgument,
          fmt::format("{}: edge {}-{}: expected at most two faces, found {}: faces {}, {}, {}{}{}",
                      source, low, high, count, first_faces[0], first_faces[1], first_faces[2],
                      count > 3 ? ", ..." : "", kRepairAdvice)};
}

Error copied_face(std::string_view source, std::uint64_t face, std::uint64_t copied) {
  return {ErrorCode::kInvalidArgument,
          fmt::format("{}: face {}: expected a new face, found a copy of face {}{}", source, face,
                      copied, kRepairAdvice)};
}

Error more_than_one_fan(std::string_view source, VertexId vertex, std::uint64_t face_count,
                        std::uint64_t faces_of_fan, std::uint64_t face_of_fan) {
  return {ErrorCode::kInvalidArgument,
          fmt::format("{}: vertex {}: expected its {} faces to form one fan, found only {} in the "
                      "fan of face {}{}",
                      source, vertex, face_count, faces_of_fan, face_of_fan, kRepairAdvice)};
}

Error repeated_corner(std::string_view source, std::uint64_t face, const FaceVertices& corners) {
  return {ErrorCode::kInvalidArgument,
          fmt::format("{}: face {}: expected three different vertices, found {} {} {}{}", source,
                      face, corners[0], corners[1], corners[2], kRepairAdvice)};
}

void check_faces(std::span<const FaceVertices> faces, std::uint64_t vertex_count,
                 const MeshSource& source) {
  const auto refuse_face = [&](std::size_t face, const std::string& what) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: face {}: {}", source.name(),
                            source.face(static_cast<FaceId>(face)), what));
  };
  for_parts(faces.size(), [&](std::size_t first, std::size_t last, std::size_t) {
    for (std::size_t face = first; face < last; ++face) {
      const FaceVertices& corners = faces[face];
      for (const VertexId vertex : corners)
        if (vertex >= vertex_count)
          refuse_face(face,
                      fmt::format("expected vertices below {}, found {}", vertex_count, vertex));
      if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0])
        throw repeated_corner(source.name(), source.face(static_cast<FaceId>(face)), corners);
    }
  });
}

std::uint64_t make_orientation_consistent(std::span<FaceVertices> faces, std::span<SideCodes> twins,
                                          const MeshSource& source) {
  enum State : std::uint8_t { kUnseen, kKept, kFlipped };
  std::vector<std::uint8_t> state(faces.size(), kUnseen);
  std::vector<FaceId> queue;
  for (FaceId seed = 0; seed < faces.size(); ++seed) {
    if (state[seed] != kUnseen) continue;
    state[seed] = kKept;
    queue.assign(1, seed);
    for (std::size_t head = 0; head < queue.size(); ++head) {
      if (is_turn_to_poll(head)) poll_interruption();
      const FaceId face = queue[head];
      for (int side = 0; side < 3; ++side) {
        const FaceSide here(face, side);
        const FaceSide beyond = from_code(entry(twins, here));
        if (!beyond.exists()) continue;
        const bool agree = start_vertex(faces, here) != start_vertex(faces, beyond);
        const auto wanted = agree == (state[face] == kKept) ? kKept : kFlipped;
        if (state[beyond.face()] == kUnseen) {
          state[beyond.face()] = wanted;
          queue.push_back(beyond.face());
        } else if (state[beyond.face()] != wanted) {
          const FaceVertices& corners = faces[face];
          throw Error(
              ErrorCode::kInvalidArgument,
              fmt::format("{}: edge {}-{}: expected faces {} and {} to have one orientation, found "
                          "none for their component: it has only one side",
                          source.name(), corners[static_cast<std::size_t>((side + 1) % 3)],
                          corners[static_cast<std::size_t>((side + 2) % 3)],
                          source.face(std::min(face, beyond.face())),
                          source.face(std::max(face, beyond.face()))));
        }
      }
    }
  }

  std::uint64_t flipped = 0, last_flipped = kNoId;
  for (FaceId face = 0; face < faces.size(); ++face) {
    for (std::uint32_t& twin : twins[face]) {
      const FaceSide beyond = from_code(twin);
      if (beyond.exists() && state[beyond.face()] == kFlipped)
        twin = FaceSide(beyond.face(), (3 - beyond.side()) % 3).code;
    }
    if (state[face] != kFlipped) continue;
    std::swap(faces[face][1], faces[face][2]);
    std::swap(twins[face][1], twins[face][2]);
    const std::uint64_t of_file = source.face(face);
    flipped += of_file == last_flipped ? 0 : 1;
    last_flipped = of_file;
  }
  return flipped;
}

std::vector<FaceSide> find_vertex_corners(std::span<const FaceVertices> faces,
                                          std::span<const SideCodes> twins,
                                          std::uint64_t vertex_count, const MeshSource& source) {
  struct Fan {
    std::uint32_t rank = kNoId;  ///< the smallest one until now
    std::uint32_t corner_count = 0;
  };
  std::vector<Fan> fans(vertex_count);
  std::vector<FaceSide> result(vertex_count);
  for (FaceId face = 0; face < faces.size(); ++face)
    for (int corner = 0; corner < 3; ++corner) {
      if (is_turn_to_poll(face)) poll_interruption();
      const VertexId vertex = faces[face][static_cast<std::size_t>(corner)];
      Fan& fan = fans[vertex];
      ++fan.corner_count;
      const bool after_border = entry(twins, FaceSide(face, (corner + 2) % 3)) == kNoId;
      const std::uint32_t rank =
          fan_rank(after_border, faces[face][static_cast<std::size_t>((corner + 1) % 3)]);
      if (rank >= fan.rank) continue;
      fan.rank = rank;
      result[vertex] = FaceSide(face, corner);
    }

  for_parts(vertex_count, [&](std::size_t first_vertex, std::size_t last_vertex, std::size_t) {
    for (std::size_t vertex = first_vertex; vertex < last_vertex; ++vertex) {
      const FaceSide first = result[vertex];
      if (!first.exists()) continue;
      std::uint32_t reached = 0;
      FaceSide corner = first;
      do {
        ++reached;
        corner = next_corner(twins, corner);
      } while (corner.exists() && corner != first);
      if (reached != fans[vertex].corner_count)
        refuse_fans(faces, twins, static_cast<VertexId>(vertex), first, source);
    }
  });
  return result;
}

std::vector<Edge> number_edges(std::span<const FaceVertices> faces, std::span<SideCodes> twins,
                               std::uint64_t border_count) {
  std::vector<Edge> edges((3 * faces.size() + border_count) / 2);
  std::vector<SideCodes> numbers(faces.size());  // [face][side] of the edges that the face numbers
  const auto is_first = [&](FaceId face, int side) {
    const FaceSide beyond = from_code(entry(twins, FaceSide(face, side)));
    return !beyond.exists() || beyond.face() > face;
  };
  number_by_first_use(faces.size(), is_first, [&](FaceId face, int side, EdgeId edge) {
    const FaceSide here(face, side), beyond = from_code(entry(twins, here));
    const VertexId start = start_vertex(faces, here);
    const VertexId end = faces[face][static_cast<std::size_t>((side + 2) % 3)];
    entry(numbers, here) = edge;
    edges[edge] = edge_of(start, end, here, beyond);
  });
  for_parts(faces.size(), [&](std::size_t first, std::size_t last, std::size_t) {
    for (std::size_t face = first; face < last; ++face)
      for (int side = 0; side < 3; ++side) {
        const FaceSide here(static_cast<FaceId>(face), side);
        std::uint32_t& code = entry(twins, here);
        code = entry(numbers, is_first(here.face(), side) ? here : from_code(code));
      }
  });
  return edges;
}

PLAIT_END_NAMESPACE
