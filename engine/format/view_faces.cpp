#include "format/view_faces.h"

#include <algorithm>
#include <array>
#include <span>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// What a corner is: a vertex that no corner before it has named; the first, ..., fourth candidate;
/// or a far one, whose place is a distance.
constexpr std::uint32_t kNewCorner = 0, kMostCandidates = 4, kFarCorner = 5, kCornerKinds = 6;
constexpr std::size_t kMostOpen = 8;

/// For each vertex the other ends of its edges that one face has passed so far: the newest ones,
/// as many as there is room for, the newest first.
class OpenEdges {
 public:
  using Ends = std::array<std::uint32_t, kMostOpen>;

  explicit OpenEdges(std::size_t vertices) {
    Ends none;
    none.fill(kNoId);
    ends_.assign(vertices, none);
  }
  std::span<const std::uint32_t> of(std::uint32_t place) const {
    const Ends& ends = ends_[place];
    return {ends.begin(), std::ranges::find(ends, kNoId)};
  }
  void add(std::uint32_t place, std::uint32_t end) {
    Ends& ends = ends_[place];
    std::shift_right(ends.begin(), ends.end(), 1);
    ends.front() = end;
  }
  bool remove(std::uint32_t place, std::uint32_t end) {
    Ends& ends = ends_[place];
    const auto found = std::ranges::find(ends, end);
    if (found == ends.end()) return false;
    std::shift_left(found, ends.end(), 1);
    ends.back() = kNoId;
    return true;
  }

 private:
  std::vector<Ends> ends_;
};

using Corners = std::array<std::uint32_t, 3>;

/// The vertices that a corner probably is, the most probable one first.
class Candidates {
 public:
  void add(std::span<const std::uint32_t> places, std::span<const std::uint32_t> named) {
    for (const std::uint32_t place : places)
      if (count_ < kMostCandidates && std::ranges::count(named, place) == 0 && number(place) == 0)
        places_[count_++] = place;
  }
  /// 1, ..., 4, or 0 if the vertex is none of them.
  std::uint32_t number(std::uint32_t place) const {
    for (std::uint32_t i = 0; i < count_; ++i)
      if (places_[i] == place) return i + 1;
    return 0;
  }

 private:
  std::array<std::uint32_t, kMostCandidates> places_{};
  std::uint32_t count_ = 0;
};

}  // namespace

ViewFaces pack_view_faces(const BaseMesh& mesh) {
  ViewFaces packed;
  packed.classes.reserve(mesh.face_count());
  packed.vertices.reserve(mesh.vertex_count());
  std::vector<std::uint32_t> places(mesh.vertex_count(), kNoId);
  OpenEdges from(mesh.vertex_count()), to(mesh.vertex_count());
  Corners before{};
  for (const auto& face : mesh.faces()) {
    Corners here{};
    std::uint32_t symbol = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      std::uint32_t& place = places[face[i]];
      const auto next = static_cast<std::uint32_t>(packed.vertices.size());
      std::uint32_t kind = kNewCorner;
      if (place == kNoId) {
        place = next;
        packed.vertices.push_back(face[i]);
      } else {
        const std::span<const std::uint32_t> named = std::span(here).first(i);
        Candidates candidates;
        if (i == 0 && !packed.classes.empty()) candidates.add(before, named);
        if (i > 0) candidates.add(from.of(here[i - 1]), named);
        if (i == 2) candidates.add(to.of(here[0]), named);
        kind = candidates.number(place);
        if (kind == 0) {
          kind = kFarCorner;
          packed.distances.push_back(next - 1 - place);
        }
      }
      here[i] = place;
      symbol = kCornerKinds * symbol + kind;
    }
    packed.classes.push_back(static_cast<std::byte>(symbol));
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t begin = here[i], end = here[(i + 1) % 3];
      if (from.remove(begin, end)) {
        to.remove(end, begin);
      } else {  // the other face will pass the edge from `end` to `begin`
        from.add(end, begin);
        to.add(begin, end);
      }
    }
    before = here;
  }
  return packed;
}

PLAIT_END_NAMESPACE
