#include "render/view.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <system_error>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr int kMaxPictureSide = 8192;

[[noreturn]] void refuse_view(std::string_view what, std::string_view text,
                              std::string_view expected) {
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("read {} \"{}\": expected {}", what, text, expected));
}

template <class Number>
bool is_whole_text(std::string_view text, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

}  // namespace

PictureSize parse_picture_size(std::string_view text) {
  PictureSize size;
  const std::size_t cross = text.find('x');
  if (cross == std::string_view::npos || !is_whole_text(text.substr(0, cross), size.width) ||
      !is_whole_text(text.substr(cross + 1), size.height) || size.width < 1 || size.height < 1 ||
      size.width > kMaxPictureSide || size.height > kMaxPictureSide)
    refuse_view("picture size", text,
                fmt::format("WIDTHxHEIGHT, each 1 to {} pixels", kMaxPictureSide));
  return size;
}

ViewAngles parse_view(std::string_view text) {
  ViewAngles view;
  const std::size_t comma = text.find(',');
  if (comma == std::string_view::npos || !is_whole_text(text.substr(0, comma), view.azimuth) ||
      !is_whole_text(text.substr(comma + 1), view.elevation) || !(std::abs(view.azimuth) <= 360) ||
      !(std::abs(view.elevation) <= 90))
    refuse_view("view", text, "AZIMUTH,ELEVATION in degrees, -360 to 360 and -90 to 90");
  return view;
}

PLAIT_END_NAMESPACE
