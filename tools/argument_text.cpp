#include "argument_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <numeric>
#include <string>

#include "plait/error.h"

namespace plait {
namespace {

constexpr int kMaxPictureSide = 8192;

[[noreturn]] void refuse(std::string_view what, std::string_view text, std::string_view expected) {
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("read {} \"{}\": expected {}", what, text, expected));
}

std::string lower_case(std::string_view text) {
  std::string lower(text);
  std::ranges::transform(lower, lower.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c;
  });
  return lower;
}

template <class Number>
bool parse_whole(std::string_view text, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

}  // namespace

double parse_tolerance(std::string_view text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(number) ||
      number < 0)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("expected a number of 0 or more, found \"{}\"", text));
  return number;
}

PictureSize parse_picture_size(std::string_view text) {
  PictureSize size;
  const std::size_t cross = text.find('x');
  if (cross == std::string_view::npos || !parse_whole(text.substr(0, cross), size.width) ||
      !parse_whole(text.substr(cross + 1), size.height) || size.width < 1 || size.height < 1 ||
      size.width > kMaxPictureSide || size.height > kMaxPictureSide)
    refuse("picture size", text, fmt::format("WIDTHxHEIGHT, each 1 to {} pixels", kMaxPictureSide));
  return size;
}

ViewAngles parse_view(std::string_view text) {
  ViewAngles view;
  const std::size_t comma = text.find(',');
  if (comma == std::string_view::npos || !parse_whole(text.substr(0, comma), view.azimuth) ||
      !parse_whole(text.substr(comma + 1), view.elevation) || !(std::abs(view.azimuth) <= 360) ||
      !(std::abs(view.elevation) <= 90))
    refuse("view", text, "AZIMUTH,ELEVATION in degrees, -360 to 360 and -90 to 90");
  return view;
}

std::string lower_extension(const std::filesystem::path& path) {
  return lower_case(path.extension().native());
}

void require_extension(std::string_view verb, const std::filesystem::path& path,
                       std::string_view extension) {
  if (lower_extension(path) != extension)
    throw Error(ErrorCode::kInvalidArgument, fmt::format("{} {}: expected a name that ends in {}",
                                                         verb, path.native(), extension));
}

std::string format_count(std::uint64_t count) {
  const std::string digits = std::to_string(count);
  std::string text;
  for (std::size_t at = 0; at < digits.size(); ++at) {
    if (at > 0 && (digits.size() - at) % 3 == 0) text += ',';
    text += digits[at];
  }
  return text;
}

std::string shell_word(std::string_view word) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./+,:=@%";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string_view::npos)
    return std::string(word);
  std::string text = "'";
  for (const char character : word)
    if (character == '\'')
      text += "'\\''";
    else
      text += character;
  return text + "'";
}

std::string command_text() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  std::string text = "plait", word;
  std::getline(file, word, '\0');  // the program, by whatever path
  while (std::getline(file, word, '\0')) {
    text += ' ';
    text += shell_word(word);
  }
  return text;
}

}  // namespace plait
