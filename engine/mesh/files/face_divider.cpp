#include "mesh/files/face_divider.h"

#include <fmt/format.h>

#include <span>
#include <vector>

#include "mesh/connectivity.h"
#include "mesh/files/polygon_ears.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

void FaceDivider::begin() {
  corners_ = 0;
  ++faces_;
}

bool FaceDivider::add(VertexId vertex) {
  if (corners_ == 0) first_ = vertex;
  if (corners_ >= 2) {
    if (mesh_.faces.size() >= kMaxFaces) return false;
    if (corners_ == 3)
      mesh_.cut_faces.push_back({static_cast<FaceId>(mesh_.faces.size() - 1), 1, faces_ - 1});
    if (corners_ >= 3) ++mesh_.cut_faces.back().triangles;
    mesh_.faces.push_back({first_, previous_, vertex});
  }
  previous_ = vertex;
  ++corners_;
  return true;
}

void FaceDivider::add_triangle(const std::array<VertexId, 3>& face) {
  ++faces_;
  mesh_.faces.push_back(face);
}

void FaceDivider::finish(const Input& input, std::uint64_t first_number,
                         std::vector<std::string>* warnings) {
  std::uint64_t not_around_first = 0;
  std::vector<VertexId> corners;
  for (const CutFace& cut : mesh_.cut_faces) {
    const auto triangles =
        std::span(mesh_.faces).subspan(cut.first_triangle, std::size_t{cut.triangles});
    if (is_divided_around_first(mesh_.positions, triangles)) continue;
    corners.assign({triangles[0][0], triangles[0][1]});
    for (const std::array<VertexId, 3>& triangle : triangles) corners.push_back(triangle[2]);
    if (const std::string problem = cut_ears(mesh_.positions, corners, triangles); !problem.empty())
      throw Error(
          ErrorCode::kInvalidArgument,
          fmt::format("read {}: face {}: expected a polygon that triangles can fill, found "
                      "{} corners {}",
                      input.path().native(), first_number + cut.number, corners.size(), problem))
          .about(input.path());
    ++not_around_first;
  }
  if (mesh_.cut_faces.empty() || warnings == nullptr) return;
  std::string text = fmt::format("{}: {} faces of more than three corners divided into triangles",
                                 input.path().native(), mesh_.cut_faces.size());
  if (not_around_first > 0)
    text += fmt::format(", {} of them, which are not convex, by cutting ears", not_around_first);
  warnings->push_back(std::move(text));
}

PLAIT_END_NAMESPACE
