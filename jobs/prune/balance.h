// prune/balance.h: depths that differ little from face to face.
#pragma once

#include <cstdint>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Makes faces deeper until faces with a common edge differ by at most `most` levels; with 0 it
/// changes nothing. Returns how many faces have become deeper.
std::uint64_t balance_depths(const Topology& mesh, int most, std::vector<std::uint8_t>& depths);

PLAIT_END_NAMESPACE
