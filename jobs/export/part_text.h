// export/part_text.h: reads from text which part of a surface is meant.
#pragma once

#include <string_view>
#include <vector>

#include "export/patch_selection.h"
#include "plait/bounds.h"
#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// "X,Y,Z,X,Y,Z": two points, the lower one first; numbers may be infinite. Errors:
/// kInvalidArgument.
Box parse_box(std::string_view text);
/// "0,7,20-29": faces, and stretches of them. Errors: kInvalidArgument.
std::vector<FaceRange> parse_faces(std::string_view text);

PLAIT_END_NAMESPACE
