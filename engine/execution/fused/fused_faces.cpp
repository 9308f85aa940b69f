#include "execution/fused/fused_faces.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <utility>

#include "plait/extend/fused.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// A face beyond the range, and the last of the faces that wait for it.
struct Ghost {
  FaceId needed_by, face;
};

/// The size of the groups in which ghosts are refined, so that most lanes have a face.
constexpr std::size_t kGhostRun = 4 * kPatchLanes;

/// The faces of the next run, if `left` faces are left: whole groups, and half of a thread's share
/// at most.
std::uint64_t next_run_faces(std::uint64_t left, std::uint64_t run_faces, int threads) {
  if (threads == 1) return run_faces;
  const std::uint64_t half_share = left / (2 * static_cast<std::uint64_t>(threads));
  return std::clamp<std::uint64_t>(half_share / kPatchLanes * kPatchLanes, kPatchLanes, run_faces);
}

}  // namespace

FusedFaces::FusedFaces(const Topology& mesh, EdgeRange edges, std::uint64_t run_faces,
                       int threads) {
  // Edges are numbered by the first face that uses them. So the first faces of the range's edges
  // ascend with the edges, and an edge's other face comes later.
  std::vector<FaceId> own;
  std::vector<Ghost> ghosts;
  if (edges.first == 0 && edges.after == mesh.edges.size()) {
    own.resize(mesh.faces.size());
    std::iota(own.begin(), own.end(), FaceId{0});
  } else {
    const auto faces_of = [&](EdgeId edge) {
      const Edge& of_mesh = mesh.edges[edge];
      const FaceId a = of_mesh.own.face();
      const FaceId b = of_mesh.is_border() ? a : of_mesh.other.face();
      return std::pair<FaceId, FaceId>(std::min(a, b), std::max(a, b));
    };
    const FaceId lowest = edges.first < edges.after ? faces_of(edges.first).first : 0,
                 last = edges.first < edges.after ? faces_of(edges.after - 1).first : 0;
    std::vector<bool> is_own(lowest <= last ? last + 1 - lowest : 0);
    bool is_beyond = false;  // in a mesh whose edges are not numbered so
    const auto list = [&](FaceId face) {
      if (const FaceId at = face - lowest; at < is_own.size()) {
        is_own[at] = true;
      } else {
        own.push_back(face);
        is_beyond = true;
      }
    };
    for (EdgeId edge = edges.first; edge < edges.after; ++edge) {
      const auto [first, other] = faces_of(edge);
      list(first);
      if (other > last)
        ghosts.push_back({first, other});
      else if (other != first)
        list(other);  // in the range of faces, perhaps without a new edge there
    }
    for (FaceId at = 0; at < is_own.size(); ++at)
      if (is_own[at]) own.push_back(lowest + at);
    if (is_beyond) {
      std::ranges::sort(own);
      own.erase(std::unique(own.begin(), own.end()), own.end());
    }
    // Of a ghost at several edges, the one that is needed first counts.
    std::ranges::sort(ghosts, [](const Ghost& a, const Ghost& b) {
      return a.face != b.face ? a.face < b.face : a.needed_by > b.needed_by;
    });
    ghosts.erase(std::unique(ghosts.begin(), ghosts.end(),
                             [](const Ghost& a, const Ghost& b) { return a.face == b.face; }),
                 ghosts.end());
    std::ranges::sort(ghosts, std::greater(), &Ghost::needed_by);
  }
  runs_.push_back(0);
  faces_.reserve(own.size() + ghosts.size());
  std::size_t next_ghost = 0;
  for (std::uint64_t after = own.size(); after > 0;) {
    const std::uint64_t first = after - std::min(after, next_run_faces(after, run_faces, threads));
    while (next_ghost < ghosts.size() && ghosts[next_ghost].needed_by >= own[first]) {
      const std::size_t end =
          std::min({ghosts.size(), next_ghost + kGhostRun, next_ghost + run_faces});
      for (; next_ghost < end; ++next_ghost) faces_.push_back(ghosts[next_ghost].face);
      std::sort(faces_.begin() + static_cast<std::ptrdiff_t>(runs_.back()), faces_.end(),
                std::greater());
      runs_.push_back(faces_.size());
    }
    for (std::uint64_t at = after; at-- > first;) faces_.push_back(own[at]);
    runs_.push_back(faces_.size());
    after = first;
  }
}

PLAIT_END_NAMESPACE
