// picture/color_map.h: numbers as colours, and the legend that explains them.
#pragma once

#include <cstddef>
#include <string>

#include "picture/image.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The colour of a share from 0 to 1: viridis (S. van der Walt and N. Smith, 2015, CC0), from dark
/// blue to yellow. Its lightness grows evenly, so people who see few colours, and grey prints, keep
/// the order. Shares outside count as the nearer end.
Rgb color_of_share(double share);

/// Vertices whose number is none.
constexpr Rgb kNoNumberColor{150, 150, 150};

struct Legend {
  std::string title;
  double low = 0, high = 1;
};
/// Rows that the legend takes of a picture, from below; 0 if the picture is too small for it.
std::size_t legend_height(std::size_t width, std::size_t height);
/// Draws a bar with the numbers at its ends and its middle along the lower edge of the picture. A
/// picture that is too small for it stays as it is.
void draw_legend(Image& image, const Legend& legend);

PLAIT_END_NAMESPACE
