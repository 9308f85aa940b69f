// Finds the twins of sides vertex by vertex: the corners at a vertex know all sides that begin or
// end there. Each side is matched where it begins.

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

#include "io/huge_pages.h"
#include "mesh/connectivity.h"
#include "mesh/parallel_parts.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// How far the loops below look ahead: the number of loads from memory that overlap.
constexpr std::size_t kFacesAhead = 16, kCornersAhead = 64;

/// The corners at all vertices: those of vertex v from after[v - 1] to after[v].
struct CornerLists {
  std::vector<std::uint32_t> after;
  HugeArray<std::uint32_t> codes;  ///< FaceSide

  /// Calls visit(vertex, corners) for these vertices. Begins to load ahead[FaceSide::code] of the
  /// corners of later ones.
  template <class Visit>
  void for_each(std::size_t first, std::size_t last, std::span<const std::uint32_t* const> ahead,
                Visit visit) const {
    std::size_t begin = first == 0 ? 0 : after[first - 1];
    for (std::size_t vertex = first; vertex < last; ++vertex) {
      const std::size_t end = after[vertex];
      if (end + kCornersAhead <= codes.size())
        for (std::size_t at = begin; at < end; ++at)
          for (const std::uint32_t* const array : ahead)
            __builtin_prefetch(array + codes[at + kCornersAhead]);
      visit(static_cast<VertexId>(vertex), std::span(codes).subspan(begin, end - begin));
      begin = end;
    }
  }
};

CornerLists corners_by_vertex(std::span<const FaceVertices> faces, std::uint64_t vertex_count) {
  CornerLists lists{huge_vector<std::uint32_t>(vertex_count),
                    HugeArray<std::uint32_t>(3 * faces.size())};
  std::vector<std::uint32_t>& after = lists.after;
  for (std::size_t face = 0; face < faces.size(); ++face) {
    if (face + kFacesAhead < faces.size())
      for (const VertexId vertex : faces[face + kFacesAhead]) __builtin_prefetch(&after[vertex], 1);
    for (const VertexId vertex : faces[face]) ++after[vertex];
  }
  std::uint32_t sum = 0;
  for (std::uint32_t& count : after) count = std::exchange(sum, sum + count);
  std::uint32_t code = 0;
  for (std::size_t face = 0; face < faces.size(); ++face) {
    if (face + 2 * kFacesAhead < faces.size()) {
      for (const VertexId vertex : faces[face + 2 * kFacesAhead])
        __builtin_prefetch(&after[vertex], 1);
      for (const VertexId vertex : faces[face + kFacesAhead])
        __builtin_prefetch(&lists.codes[after[vertex]], 1);
    }
    // Filling a list moves after[v] from the beginning of the list to its end.
    for (const VertexId vertex : faces[face]) lists.codes[after[vertex]++] = code++;
  }
  return lists;
}

[[noreturn]] void refuse_shared_edge(VertexId low, std::span<const std::uint64_t> same_edge,
                                     const MeshSource& source) {
  const auto face_at = [&](std::size_t at) {
    return source.face(from_code(static_cast<std::uint32_t>(same_edge[at])).face());
  };
  const std::array<std::uint64_t, 3> first_faces = {face_at(0), face_at(1), face_at(2)};
  throw too_many_faces_at_edge(source.name(), low, static_cast<VertexId>(same_edge[0] >> 32),
                               first_faces, same_edge.size());
}

/// What a part of the vertices says about the mesh.
struct MatchedPart {
  std::uint64_t border_count = 0;
  bool oriented = true, has_plain_fans = true;
};

/// The corners at one vertex, each with the corner that follows it counterclockwise.
class PlainFan {
 public:
  /// Returns whether the faces are a plain fan (connectivity.h). Without branches that depend on
  /// the order of the faces, which the processor could not predict. `vertices` are those of the
  /// faces, [FaceSide::code].
  bool find(const VertexId* vertices, VertexId vertex, std::span<const std::uint32_t> corners) {
    count_ = corners.size();
    is_on_border_ = false;
    if (count_ == 6) return find_among<6>(vertices, vertex, corners);  // nearly always
    return count_ == 0 || (count_ <= kMostInPlainFan && find_among<0>(vertices, vertex, corners));
  }
  /// Matches the sides that begin at the vertex. REQUIRES: find() returned true.
  void match(std::uint32_t* twins) const {
    for (std::size_t at = 0; at < count_; ++at) twins[outgoing_[at]] = incoming_[beyond_[at]];
  }
  bool is_on_border() const { return is_on_border_; }

 private:
  /// `kCount` is the number of corners, or 0 if the compiler does not know it.
  template <std::size_t kCount>
  bool find_among(const VertexId* vertices, VertexId vertex,
                  std::span<const std::uint32_t> corners);
  bool is_one_fan(std::size_t count, std::uint64_t reached) const;

  std::size_t count_ = 0;
  bool is_on_border_ = false;
  std::array<VertexId, kMostInPlainFan> next_, before_;  ///< the other vertices of the faces
  std::array<std::uint32_t, kMostInPlainFan> outgoing_;  ///< sides
  std::array<std::uint32_t, kMostInPlainFan + 1> incoming_;
  std::array<std::uint32_t, kMostInPlainFan> beyond_;  ///< the corner that follows, or count_
};

template <std::size_t kCount>
bool PlainFan::find_among(const VertexId* vertices, VertexId vertex,
                          std::span<const std::uint32_t> corners) {
  const std::size_t count = kCount != 0 ? kCount : count_;
  bool once = true;
  for (std::size_t at = 0; at < count; ++at) {
    const std::uint32_t corner = corners[at], side = corner % 3;
    const std::uint32_t one = corner + 1 - 3 * (side >> 1);
    const std::uint32_t two = corner + 2 - 3 * ((side + 1) >> 1);
    next_[at] = vertices[one];
    before_[at] = vertices[two];
    outgoing_[at] = two;
    incoming_[at] = one;
    once &= next_[at] != vertex;
  }
  incoming_[count] = kNoId;
  std::uint64_t reached = 0;
  for (std::size_t at = 0; at < count; ++at) {
    std::uint64_t hits = 0;
    for (std::size_t other = 0; other < count; ++other)
      hits |= std::uint64_t{before_[other] == next_[at]} << other;
    once &= (hits & (hits - 1)) == 0;
    hits |= std::uint64_t{1} << count;
    beyond_[at] = static_cast<std::uint32_t>(std::countr_zero(hits));
    reached |= hits & -hits;
  }
  is_on_border_ = (reached >> count & 1) != 0;
  return once && is_one_fan(count, reached);
}

/// From its first corner on, each corner of a fan leads to another one, and the last to the first
/// or to the border. `reached` has a bit for each corner that follows another one, and for the
/// border.
bool PlainFan::is_one_fan(std::size_t count, std::uint64_t reached) const {
  std::size_t first = 0;  // the corner that follows none, if one leads to the border
  if (is_on_border_)
    while ((reached >> first & 1) != 0) ++first;
  std::size_t corner = beyond_[first], length = 1;
  while (corner != count && corner != first && length < count) {
    ++length;
    corner = beyond_[corner];
  }
  return length == count && (corner == count || corner == first);
}

class SideMatcher {
 public:
  SideMatcher(std::span<const FaceVertices> faces, std::uint32_t* twins, const MeshSource& source,
              MatchedPart& found)
      : faces_(faces), twins_(twins), source_(source), found_(found) {}

  /// Matches the sides that begin at a vertex. Errors: those of match_sides().
  void match(VertexId vertex, std::span<const std::uint32_t> corners) {
    if (!fan_.find(faces_[0].data(), vertex, corners)) {
      found_.has_plain_fans = false;
      return match_any(vertex, corners);
    }
    fan_.match(twins_);
    found_.border_count += fan_.is_on_border() ? 1u : 0u;
  }

 private:
  void match_any(VertexId vertex, std::span<const std::uint32_t> corners);
  void match_edge(VertexId vertex, std::span<const std::uint64_t> same_edge);

  std::span<const FaceVertices> faces_;
  std::uint32_t* twins_;  ///< [FaceSide::code]
  const MeshSource& source_;
  MatchedPart& found_;
  PlainFan fan_;
  std::vector<std::uint64_t> sides_;  ///< of match_any()
};

void SideMatcher::match_any(VertexId vertex, std::span<const std::uint32_t> corners) {
  // One word holds (other vertex of the edge, code of the side), so that sorting reads no faces.
  sides_.clear();
  for (const std::uint32_t code : corners) {
    const FaceSide corner = from_code(code);
    for (const int turn : {1, 2}) {
      const int side = (corner.side() + 3 - turn) % 3, other = (corner.side() + turn) % 3;
      sides_.push_back(std::uint64_t{faces_[corner.face()][static_cast<std::size_t>(other)]} << 32 |
                       FaceSide(corner.face(), side).code);
    }
  }
  std::ranges::sort(sides_);
  for (std::size_t first = 0; first < sides_.size();) {
    std::size_t after = first + 1;
    while (after < sides_.size() && sides_[after] >> 32 == sides_[first] >> 32) ++after;
    match_edge(vertex, std::span(sides_).subspan(first, after - first));
    first = after;
  }
}

/// Both vertices of an edge see the same sides. The lower one reports what is wrong.
void SideMatcher::match_edge(VertexId vertex, std::span<const std::uint64_t> same_edge) {
  const bool reports = vertex < same_edge[0] >> 32;
  if (same_edge.size() > 2) {
    if (reports) refuse_shared_edge(vertex, same_edge, source_);
    return;
  }
  const FaceSide one = from_code(static_cast<std::uint32_t>(same_edge[0]));
  const FaceSide two =
      same_edge.size() == 1 ? FaceSide() : from_code(static_cast<std::uint32_t>(same_edge[1]));
  const bool one_begins = start_vertex(faces_, one) == vertex;
  const bool two_begins = two.exists() && start_vertex(faces_, two) == vertex;
  if (one_begins) twins_[one.code] = two.code;
  if (two_begins) twins_[two.code] = one.code;
  if (!two.exists()) found_.border_count += one_begins ? 1u : 0u;
  if (!two.exists() || one_begins != two_begins) return;
  found_.oriented = false;
  if (reports && opposite_vertex(faces_, one) == opposite_vertex(faces_, two))
    throw copied_face(source_.name(), source_.face(two.face()), source_.face(one.face()));
}

}  // namespace

MatchedSides match_sides(std::span<const FaceVertices> faces, std::uint64_t vertex_count,
                         const MeshSource& source, std::vector<SideCodes> room) {
  MatchedSides result;
  if (faces.empty()) return result;
  const CornerLists lists = corners_by_vertex(faces, vertex_count);
  if (room.size() != faces.size()) room = huge_vector<SideCodes>(faces.size());
  result.twins = std::move(room);
  std::uint32_t* const twins = result.twins[0].data();
  const std::array<const std::uint32_t*, 2> ahead = {faces[0].data(), twins};
  std::vector<MatchedPart> parts(part_count(vertex_count));
  for_parts(vertex_count, [&](std::size_t first, std::size_t last, std::size_t part) {
    SideMatcher matcher(faces, twins, source, parts[part]);
    lists.for_each(first, last, ahead,
                   [&](VertexId vertex, std::span<const std::uint32_t> corners) {
                     matcher.match(vertex, corners);
                   });
  });
  for (const MatchedPart& part : parts) {
    result.border_count += part.border_count;
    result.oriented = result.oriented && part.oriented;
    result.has_plain_fans = result.has_plain_fans && part.has_plain_fans;
  }
  return result;
}

std::vector<VertexId> without_plain_fan(std::span<const FaceVertices> faces,
                                        std::uint64_t vertex_count) {
  if (faces.empty()) return {};
  const CornerLists lists = corners_by_vertex(faces, vertex_count);
  const std::array<const std::uint32_t*, 1> ahead = {faces[0].data()};
  std::vector<std::vector<VertexId>> parts(part_count(vertex_count));
  for_parts(vertex_count, [&](std::size_t first, std::size_t last, std::size_t part) {
    PlainFan fan;
    lists.for_each(first, last, ahead,
                   [&](VertexId vertex, std::span<const std::uint32_t> corners) {
                     if (!fan.find(ahead[0], vertex, corners)) parts[part].push_back(vertex);
                   });
  });
  std::vector<VertexId> result;
  for (const std::vector<VertexId>& part : parts)
    result.insert(result.end(), part.begin(), part.end());
  return result;
}

PLAIT_END_NAMESPACE
