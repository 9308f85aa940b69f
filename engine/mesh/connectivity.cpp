#include "mesh/connectivity.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "mesh/parallel_parts.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The order in which the sides of a face number edges: ab, bc, ca.
constexpr std::array<int, 3> kSideOrder = {2, 0, 1};

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

FaceSide from_code(std::uint32_t code) {
  FaceSide side;
  side.code = code;
  return side;
}

VertexId opposite_vertex(std::span<const FaceVertices> faces, FaceSide half_edge) {
  return faces[half_edge.face()][static_cast<std::size_t>(half_edge.side())];
}

[[noreturn]] void refuse_shared_edge(VertexId low, std::span<const std::uint64_t> same_edge,
                                     std::string_view source) {
  const auto face_at = [&](std::size_t at) {
    return from_code(static_cast<std::uint32_t>(same_edge[at])).face();
  };
  throw Error(
      ErrorCode::kInvalidArgument,
      fmt::format("{}: edge {}-{}: expected at most two faces, found {}: faces {}, {}, {}{}",
                  source, low, same_edge[0] >> 32, same_edge.size(), face_at(0), face_at(1),
                  face_at(2), same_edge.size() > 3 ? ", ..." : ""));
}

/// Makes the two half-edges of an edge twins of each other, or counts a border edge. Returns
/// whether the two half-edges run in opposite directions.
bool match(std::span<const FaceVertices> faces, std::span<const std::uint64_t> same_edge,
           VertexId low, std::string_view source, std::span<SideCodes> twins,
           std::uint64_t& border_count) {
  if (same_edge.size() > 2) refuse_shared_edge(low, same_edge, source);
  const FaceSide one = from_code(static_cast<std::uint32_t>(same_edge[0]));
  if (same_edge.size() == 1) {
    entry(twins, one) = kNoId;
    ++border_count;
    return true;
  }
  const FaceSide two = from_code(static_cast<std::uint32_t>(same_edge[1]));
  entry(twins, one) = two.code;
  entry(twins, two) = one.code;
  if (start_vertex(faces, one) != start_vertex(faces, two)) return true;
  if (opposite_vertex(faces, one) == opposite_vertex(faces, two))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: face {}: expected a new face, found a copy of face {}", source,
                            two.face(), one.face()));
  return false;
}

}  // namespace

void check_faces(std::span<const FaceVertices> faces, std::uint64_t vertex_count,
                 std::string_view source) {
  const auto refuse_face = [&](std::size_t face, const std::string& what) {
    throw Error(ErrorCode::kInvalidArgument, fmt::format("{}: face {}: {}", source, face, what));
  };
  for_parts(faces.size(), [&](std::size_t first, std::size_t last, std::size_t) {
    for (std::size_t face = first; face < last; ++face) {
      const FaceVertices& corners = faces[face];
      for (const VertexId vertex : corners)
        if (vertex >= vertex_count)
          refuse_face(face,
                      fmt::format("expected vertices below {}, found {}", vertex_count, vertex));
      if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0])
        refuse_face(face, fmt::format("expected three different vertices, found {} {} {}",
                                      corners[0], corners[1], corners[2]));
    }
  });
}

MatchedSides match_sides(std::span<const FaceVertices> faces, std::uint64_t vertex_count,
                         std::string_view source) {
  std::vector<std::uint32_t> bucket(vertex_count, 0);
  for (const FaceVertices& face : faces)
    for (std::size_t side = 0; side < 3; ++side)
      ++bucket[std::min(face[(side + 1) % 3], face[(side + 2) % 3])];
  std::uint32_t sum = 0;
  for (std::uint32_t& count : bucket) count = std::exchange(sum, sum + count);

  // One word holds (higher vertex, half-edge code), so that sorting a bucket does not read faces.
  const auto entries = std::make_unique_for_overwrite<std::uint64_t[]>(sum);
  for (FaceId face = 0; face < faces.size(); ++face)
    for (int side = 0; side < 3; ++side) {
      const FaceVertices& corners = faces[face];
      const VertexId start = corners[static_cast<std::size_t>((side + 1) % 3)];
      const VertexId end = corners[static_cast<std::size_t>((side + 2) % 3)];
      entries[bucket[std::min(start, end)]++] =
          std::uint64_t{std::max(start, end)} << 32 | FaceSide(face, side).code;
    }

  MatchedSides result;
  result.twins.resize(faces.size());
  struct SideCounts {
    std::uint64_t border_count = 0;
    bool oriented = true;
  };
  std::vector<SideCounts> parts(part_count(vertex_count));
  for_parts(vertex_count, [&](std::size_t first_low, std::size_t last_low, std::size_t part) {
    for (std::size_t low = first_low; low < last_low; ++low) {
      // Filling the buckets has moved bucket[low] from the beginning of the bucket to its end.
      std::uint32_t first = low == 0 ? 0 : bucket[low - 1];
      const std::uint32_t last = bucket[low];
      std::sort(&entries[first], &entries[last]);
      while (first < last) {
        std::uint32_t next = first + 1;
        while (next < last && entries[next] >> 32 == entries[first] >> 32) ++next;
        const std::span<const std::uint64_t> same_edge(&entries[first], next - first);
        if (!match(faces, same_edge, static_cast<VertexId>(low), source, result.twins,
                   parts[part].border_count))
          parts[part].oriented = false;
        first = next;
      }
    }
  });
  for (const SideCounts& part : parts) {
    result.border_count += part.border_count;
    result.oriented = result.oriented && part.oriented;
  }
  return result;
}

std::uint64_t make_orientation_consistent(std::span<FaceVertices> faces, std::span<SideCodes> twins,
                                          std::string_view source) {
  enum State : std::uint8_t { kUnseen, kKept, kFlipped };
  std::vector<std::uint8_t> state(faces.size(), kUnseen);
  std::vector<FaceId> queue;
  for (FaceId seed = 0; seed < faces.size(); ++seed) {
    if (state[seed] != kUnseen) continue;
    state[seed] = kKept;
    queue.assign(1, seed);
    for (std::size_t head = 0; head < queue.size(); ++head) {
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
                          source, corners[static_cast<std::size_t>((side + 1) % 3)],
                          corners[static_cast<std::size_t>((side + 2) % 3)],
                          std::min(face, beyond.face()), std::max(face, beyond.face())));
        }
      }
    }
  }

  std::uint64_t flipped = 0;
  for (FaceId face = 0; face < faces.size(); ++face) {
    for (std::uint32_t& twin : twins[face]) {
      const FaceSide beyond = from_code(twin);
      if (beyond.exists() && state[beyond.face()] == kFlipped)
        twin = FaceSide(beyond.face(), (3 - beyond.side()) % 3).code;
    }
    if (state[face] != kFlipped) continue;
    std::swap(faces[face][1], faces[face][2]);
    std::swap(twins[face][1], twins[face][2]);
    ++flipped;
  }
  return flipped;
}

std::vector<FaceSide> find_vertex_corners(std::span<const FaceVertices> faces,
                                          std::span<const SideCodes> twins,
                                          std::uint64_t vertex_count, std::string_view source) {
  constexpr std::uint32_t kAfterBorder = 0;
  struct Fan {
    /// The corner of smallest rank is the fan's first. kAfterBorder after a border edge, else 1 +
    /// the vertex of the next corner.
    std::uint32_t rank = kNoId;
    std::uint32_t corner_count = 0;
  };
  std::vector<Fan> fans(vertex_count);
  std::vector<FaceSide> result(vertex_count);
  for (FaceId face = 0; face < faces.size(); ++face)
    for (int corner = 0; corner < 3; ++corner) {
      const VertexId vertex = faces[face][static_cast<std::size_t>(corner)];
      Fan& fan = fans[vertex];
      ++fan.corner_count;
      const bool after_border = entry(twins, FaceSide(face, (corner + 2) % 3)) == kNoId;
      const std::uint32_t rank =
          after_border ? kAfterBorder : 1 + faces[face][static_cast<std::size_t>((corner + 1) % 3)];
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
        const FaceSide beyond =
            from_code(entry(twins, FaceSide(corner.face(), (corner.side() + 1) % 3)));
        corner = beyond.exists() ? FaceSide(beyond.face(), (beyond.side() + 1) % 3) : FaceSide();
      } while (corner.exists() && corner != first);
      if (reached != fans[vertex].corner_count)
        throw Error(
            ErrorCode::kInvalidArgument,
            fmt::format("{}: vertex {}: expected its {} faces to form one fan, found only {} "
                        "in the fan of face {}",
                        source, vertex, fans[vertex].corner_count, reached, first.face()));
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
    if (!beyond.exists() || start < end)
      edges[edge] = {start, end, here, beyond};
    else
      edges[edge] = {end, start, beyond, here};
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
