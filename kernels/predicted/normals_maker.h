// Makes the blocks of normals again from stored positions: the rule "normals".
#pragma once

#include <memory>

#include "plait/extend/block_maker.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// nullptr if the level or the source is not suitable: the source is an earlier attribute of 3
/// float32 or float64 with `source.levels` levels.
std::unique_ptr<BlockMaker> make_normals_maker(const RecipeSource& source, const MadeLevel& level);

PLAIT_END_NAMESPACE
