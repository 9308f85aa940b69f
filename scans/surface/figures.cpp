#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/interruption.h"
#include "surface/edge_pairs.h"
#include "surface/repair.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

bool has_fold(const Surface& surface, FaceSide side) {
  const FaceSide beyond = surface.across[side.code];
  if (!beyond.exists()) return false;
  const auto normal_of = [&](FaceId face) {
    return area_vector(surface.corner(face, 0), surface.corner(face, 1), surface.corner(face, 2));
  };
  return is_folded(normal_of(side.face()), normal_of(beyond.face()));
}

}  // namespace

SurfaceFigures figures_of(const Surface& surface) {
  SurfaceFigures figures;
  figures.vertices = surface.positions.size();
  figures.faces = surface.faces.size();
  for (const FaceSide beyond : surface.across) figures.border_edges += beyond.exists() ? 0u : 1u;
  figures.edges = (3 * figures.faces + figures.border_edges) / 2;
  std::vector<std::uint32_t> component;
  figures.components = face_components(surface.faces.size(), surface.across, component).size();
  for_each_border(surface.faces.size(), surface.across,
                  [&](const std::vector<FaceSide>&) { ++figures.borders; });
  figures.euler_number = static_cast<std::int64_t>(figures.vertices + figures.faces) -
                         static_cast<std::int64_t>(figures.edges);
  for (FaceId face = 0; face < surface.faces.size(); ++face)
    for (int at = 0; at < 3; ++at) {
      if (is_turn_to_poll(face)) poll_interruption();
      if (const FaceSide side(face, at); side.code < surface.across[side.code].code)
        figures.folded_edges += has_fold(surface, side) ? 1u : 0u;
    }
  return figures;
}

PLAIT_END_NAMESPACE
