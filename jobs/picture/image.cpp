#include "picture/image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

Rgb blend(Rgb from, Rgb to, double fraction) {
  const double part = std::clamp(fraction, 0.0, 1.0);
  const auto channel = [part](std::uint8_t a, std::uint8_t b) {
    return static_cast<std::uint8_t>(std::lround(a + part * (b - a)));
  };
  return {channel(from.red, to.red), channel(from.green, to.green), channel(from.blue, to.blue)};
}

Image::Image(std::size_t width, std::size_t height, Rgb background)
    : width_(width), height_(height) {
  constexpr std::size_t kMost = 65535;
  if (width < 1 || width > kMost || height < 1 || height > kMost)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("make image: expected sides of 1 to {} pixels, found {} x {}", kMost,
                            width, height));
  pixels_.assign(width * height, background);
}

void Image::fill_rectangle(std::size_t x, std::size_t y, std::size_t width, std::size_t height,
                           Rgb colour) {
  const std::size_t x_end = x + std::min(width, width_ - std::min(x, width_));
  const std::size_t y_end = y + std::min(height, height_ - std::min(y, height_));
  for (std::size_t row = y; row < y_end; ++row)
    for (std::size_t column = x; column < x_end; ++column) at(column, row) = colour;
}

PLAIT_END_NAMESPACE
