// picture/text.h: short captions in a built-in font of capital letters, digits and a few marks.
#pragma once

#include <cstddef>
#include <string_view>

#include "picture/image.h"

PLAIT_BEGIN_NAMESPACE

constexpr std::size_t kGlyphWidth = 5, kGlyphHeight = 7, kGlyphAdvance = 6;  ///< at scale 1

/// Writes `text` with its upper left corner at (x, y); small letters become capitals, and
/// characters that the font lacks become spaces. Parts outside the image are ignored.
void draw_text(Image& image, std::size_t x, std::size_t y, std::string_view text, Rgb colour,
               std::size_t scale);

PLAIT_END_NAMESPACE
