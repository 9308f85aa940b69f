// What the commands say about blocks that a store makes again instead of containing them.
#pragma once

#include <string>

#include "plait/store.h"

namespace plait {

/// "normal: 96 of 96 blocks take no bytes; reading makes them again (normals/position/5)", and a
/// line end. Empty if every block of the attribute takes bytes.
std::string made_blocks_text(const Store& store, AttributeId attribute);

}  // namespace plait
