// render/view.h: the size of a picture and the direction of the view, from the text of an option.
#pragma once

#include <cstdint>
#include <string_view>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct PictureSize {
  int width = 0, height = 0;  ///< pixels, 1 to 8192
};
/// "1600x1200". Errors: kInvalidArgument.
PictureSize parse_picture_size(std::string_view text);

struct ViewAngles {
  double azimuth = 0, elevation = 0;  ///< degrees
};
/// "30,20": azimuth -360 to 360, elevation -90 to 90. Errors: kInvalidArgument.
ViewAngles parse_view(std::string_view text);

enum class UpAxis : std::uint8_t { kX, kY, kZ };

PLAIT_END_NAMESPACE
