#include "surface/orient.h"

#include <fmt/format.h>

#include <cstddef>
#include <utility>

#include "base/interruption.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

std::uint64_t orient_faces(std::vector<std::array<VertexId, 3>>& faces,
                           std::vector<FaceSide>& across, std::span<const VertexId> origin,
                           std::string_view source) {
  const auto face_count = static_cast<FaceId>(faces.size());
  const auto corner = [&](FaceId face, int at) {
    return faces[face][static_cast<std::size_t>(at % 3)];
  };
  std::uint64_t count = 0;
  std::vector<std::uint8_t> turned(faces.size(), 0), seen(faces.size(), 0);
  std::vector<FaceId> component;
  for (FaceId first = 0; first < face_count; ++first) {
    if (seen[first] != 0) continue;
    component.assign(1, first);
    seen[first] = 1;
    std::size_t turned_count = 0;
    for (std::size_t at = 0; at < component.size(); ++at) {
      if (is_turn_to_poll(at)) poll_interruption();
      const FaceId face = component[at];
      for (int side = 0; side < 3; ++side) {
        const FaceSide beyond = across[FaceSide(face, side).code];
        if (!beyond.exists()) continue;
        // Two faces agree if they run through their edge in opposite directions.
        const bool agrees = corner(face, side + 1) == corner(beyond.face(), beyond.side() + 2);
        const auto expected = static_cast<std::uint8_t>(agrees ? turned[face] : 1 - turned[face]);
        if (seen[beyond.face()] != 0) {
          if (turned[beyond.face()] == expected) continue;
          throw Error(
              ErrorCode::kInvalidArgument,
              fmt::format("{}: the edge of the vertices {} and {}: expected a surface with two "
                          "sides, found a component that cannot be oriented",
                          source, origin[corner(face, side + 1)], origin[corner(face, side + 2)]));
        }
        seen[beyond.face()] = 1;
        turned[beyond.face()] = expected;
        turned_count += expected;
        component.push_back(beyond.face());
      }
    }
    const bool turn_others = 2 * turned_count > component.size();
    for (const FaceId face : component) {
      if ((turned[face] != 0) == turn_others) continue;
      ++count;
      turned[face] = 2;
    }
  }
  if (count == 0) return 0;
  for (FaceId face = 0; face < face_count; ++face)
    if (turned[face] == 2) std::swap(faces[face][1], faces[face][2]);
  // The corners 1 and 2 have changed places, and so have the sides opposite of them.
  const std::vector<FaceSide> before = across;
  const auto now = [&](FaceSide side) {
    if (!side.exists() || turned[side.face()] != 2 || side.side() == 0) return side;
    return FaceSide(side.face(), 3 - side.side());
  };
  for (std::size_t code = 0; code < before.size(); ++code) {
    FaceSide side;
    side.code = static_cast<std::uint32_t>(code);
    across[now(side).code] = now(before[code]);
  }
  return count;
}

PLAIT_END_NAMESPACE
