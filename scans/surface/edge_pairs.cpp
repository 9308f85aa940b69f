#include "surface/edge_pairs.h"

#include <algorithm>

#include "base/interruption.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

std::uint64_t pair_sides(std::size_t vertices, std::span<const std::array<VertexId, 3>> faces,
                         std::vector<FaceSide>& across) {
  const std::size_t sides = 3 * faces.size();
  across.assign(sides, FaceSide());
  const auto low = [&](std::size_t side) {
    return std::min(faces[side / 3][(side + 1) % 3], faces[side / 3][(side + 2) % 3]);
  };
  const auto high = [&](std::size_t side) {
    return std::max(faces[side / 3][(side + 1) % 3], faces[side / 3][(side + 2) % 3]);
  };
  // The sides whose lower vertex is v are a list: first[v], then next[side]; latest side first.
  std::vector<std::uint32_t> first(vertices, kNoId), next(sides);
  for (std::size_t side = 0; side < sides; ++side) {
    if (is_turn_to_poll(side)) poll_interruption();
    next[side] = first[low(side)];
    first[low(side)] = static_cast<std::uint32_t>(side);
  }
  std::uint64_t shared = 0;
  for (std::size_t side = 0; side < sides; ++side) {
    if (is_turn_to_poll(side)) poll_interruption();
    std::uint32_t other = kNoId;
    std::size_t count = 0;
    bool is_first = true;
    for (std::uint32_t at = first[low(side)]; at != kNoId; at = next[at]) {
      if (at == side || high(at) != high(side)) continue;
      other = at;
      is_first = is_first && side < at;
      ++count;
    }
    if (count == 1) across[side].code = other;
    if (count > 1 && is_first) ++shared;
  }
  return shared;
}

std::vector<std::uint64_t> face_components(std::size_t faces, std::span<const FaceSide> across,
                                           std::vector<std::uint32_t>& component) {
  component.assign(faces, kNoId);
  std::vector<std::uint64_t> sizes;
  std::vector<FaceId> waiting;
  for (FaceId first = 0; first < faces; ++first) {
    if (component[first] != kNoId) continue;
    const auto number = static_cast<std::uint32_t>(sizes.size());
    sizes.push_back(0);
    component[first] = number;
    waiting.assign(1, first);
    while (!waiting.empty()) {
      const FaceId face = waiting.back();
      waiting.pop_back();
      if (is_turn_to_poll(++sizes.back())) poll_interruption();
      for (int side = 0; side < 3; ++side) {
        const FaceSide beyond = across[FaceSide(face, side).code];
        if (!beyond.exists() || component[beyond.face()] != kNoId) continue;
        component[beyond.face()] = number;
        waiting.push_back(beyond.face());
      }
    }
  }
  return sizes;
}

PLAIT_END_NAMESPACE
