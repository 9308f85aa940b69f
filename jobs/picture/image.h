// picture/image.h: a rectangle of 8-bit sRGB pixels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

struct Rgb {
  std::uint8_t red, green, blue;
  friend constexpr bool operator==(const Rgb&, const Rgb&) = default;
};
static_assert(sizeof(Rgb) == 3, "rows go to the PNG encoder without conversion");

/// Mixes two colours: `from` for fraction 0, `to` for fraction 1. Fractions outside count as the
/// nearer end.
Rgb blend(Rgb from, Rgb to, double fraction);

class Image {
 public:
  /// Errors: kInvalidArgument unless both sides are 1 to 65,535 pixels.
  Image(std::size_t width, std::size_t height, Rgb background);

  std::size_t width() const { return width_; }
  std::size_t height() const { return height_; }
  /// x to the right, y down. REQUIRES: inside the image.
  Rgb& at(std::size_t x, std::size_t y) { return pixels_[y * width_ + x]; }
  const Rgb& at(std::size_t x, std::size_t y) const { return pixels_[y * width_ + x]; }
  /// [y][x]
  std::span<const Rgb> pixels() const { return pixels_; }

  /// Parts outside the image are ignored.
  void fill_rectangle(std::size_t x, std::size_t y, std::size_t width, std::size_t height,
                      Rgb colour);

 private:
  std::size_t width_, height_;
  std::vector<Rgb> pixels_;
};

PLAIT_END_NAMESPACE
