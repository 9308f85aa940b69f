#include "export/part_text.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <system_error>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

template <class Number>
bool parse_item(std::string_view text, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

/// Takes the text before the next comma from `rest`.
std::string_view next_item(std::string_view& rest) {
  const std::size_t comma = std::min(rest.find(','), rest.size());
  const std::string_view item = rest.substr(0, comma);
  rest.remove_prefix(std::min(comma + 1, rest.size()));
  return item;
}

}  // namespace

Box parse_box(std::string_view text) {
  std::array<double, 6> numbers{};
  std::string_view rest = text;
  bool good = !text.ends_with(',');
  for (double& number : numbers) good = good && parse_item(next_item(rest), number);
  const auto& [x, y, z, to_x, to_y, to_z] = numbers;
  if (!good || !rest.empty() || !(x <= to_x) || !(y <= to_y) || !(z <= to_z))
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("read box \"{}\": expected X,Y,Z,X,Y,Z, and the lower point first", text));
  return {{x, y, z}, {to_x, to_y, to_z}};
}

std::vector<FaceRange> parse_faces(std::string_view text) {
  std::vector<FaceRange> ranges;
  std::string_view rest = text;
  bool good = !text.empty() && !text.ends_with(',');
  while (good && !rest.empty()) {
    const std::string_view item = next_item(rest);
    const std::size_t dash = std::min(item.find('-'), item.size());
    FaceRange range;
    good = parse_item(item.substr(0, dash), range.first);
    range.last = range.first;
    if (dash < item.size()) good = good && parse_item(item.substr(dash + 1), range.last);
    good = good && range.first <= range.last;
    ranges.push_back(range);
  }
  if (!good)
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("read faces \"{}\": expected numbers and stretches, such as 0,7,20-29", text));
  return ranges;
}

PLAIT_END_NAMESPACE
