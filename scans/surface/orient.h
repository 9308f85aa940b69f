// surface/orient.h: turns the faces of a mesh so that neighbours agree.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "surface/surface.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Turns faces until all of a component agree with most of them, and `across` with them: the side
/// beyond each side. Returns how many it has turned. O(F). Errors: kInvalidArgument for a component
/// that cannot be oriented (a Moebius strip), with one of its edges; `source` begins the message,
/// and `origin` has the numbers of the vertices for it.
std::uint64_t orient_faces(std::vector<std::array<VertexId, 3>>& faces,
                           std::vector<FaceSide>& across, std::span<const VertexId> origin,
                           std::string_view source);

PLAIT_END_NAMESPACE
