#include "picture/color_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "picture/text.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::array<Rgb, 11> kViridis = {{{68, 1, 84},
                                           {72, 36, 117},
                                           {65, 68, 135},
                                           {53, 95, 141},
                                           {42, 120, 142},
                                           {33, 145, 140},
                                           {34, 168, 132},
                                           {68, 191, 112},
                                           {122, 209, 81},
                                           {189, 223, 38},
                                           {253, 231, 37}}};
constexpr Rgb kLegendInk{40, 44, 52};
constexpr std::size_t kLeastWidth = 120, kLeastHeight = 60;

std::size_t scale_of(std::size_t width) { return std::max<std::size_t>(1, width / 600); }
std::size_t line_height(std::size_t scale) { return (kGlyphHeight + 3) * scale; }

}  // namespace

Rgb color_of_share(double share) {
  const double place = std::clamp(share, 0.0, 1.0) * static_cast<double>(kViridis.size() - 1);
  const auto first = std::min(static_cast<std::size_t>(place), kViridis.size() - 2);
  return blend(kViridis[first], kViridis[first + 1], place - static_cast<double>(first));
}

std::size_t legend_height(std::size_t width, std::size_t height) {
  return width < kLeastWidth || height < kLeastHeight ? 0 : 3 * line_height(scale_of(width));
}

void draw_legend(Image& image, const Legend& legend) {
  if (legend_height(image.width(), image.height()) == 0) return;
  const std::size_t scale = scale_of(image.width()), line = line_height(scale);
  const std::size_t width = image.width() / 2, left = image.width() / 4;
  const std::size_t numbers = image.height() - line, bar = numbers - line;
  for (std::size_t x = 0; x < width; ++x)
    image.fill_rectangle(left + x, bar, 1, line - 2 * scale,
                         color_of_share(static_cast<double>(x) / static_cast<double>(width - 1)));
  const auto write = [&](std::size_t middle, std::size_t y, const std::string& text) {
    const std::size_t half = text.size() * kGlyphAdvance * scale / 2;
    draw_text(image, middle > half ? middle - half : 0, y, text, kLegendInk, scale);
  };
  write(left + width / 2, bar - line, legend.title);
  for (const double share : {0.0, 0.5, 1.0})
    write(left + static_cast<std::size_t>(share * static_cast<double>(width)), numbers,
          fmt::format("{:.4g}", legend.low + share * (legend.high - legend.low)));
}

PLAIT_END_NAMESPACE
