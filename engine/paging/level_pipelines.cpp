#include "plait/level_pipelines.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The most characters of a text in a message, because a message is one line.
constexpr std::size_t kMostAttributesNamed = 100;

/// Reads a level from the beginning of `text`, and removes its digits.
bool take_level(std::string_view& text, int& level) {
  if (text.empty() || text.front() < '0' || text.front() > '9') return false;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), level);
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return error == std::errc() && level <= kMaxLevel;
}

/// Removes the text up to the separator from `text`, and returns it.
std::string_view take_until(std::string_view& text, char separator) {
  const std::string_view part = text.substr(0, text.find(separator));
  text.remove_prefix(std::min(part.size() + 1, text.size()));
  return part;
}

}  // namespace

LevelRange LevelRange::parse(std::string_view text) {
  LevelRange range;
  std::string_view rest = text;
  bool is_range = take_level(rest, range.first);
  if (rest.empty())
    range.last = range.first;
  else if (rest != "-")
    is_range = is_range && take_until(rest, '-').empty() && take_level(rest, range.last) &&
               rest.empty() && range.first <= range.last;
  if (!is_range)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("choose levels: expected levels of 0 to {} such as 4, 1-3 or 6-, found "
                            "\"{}\"",
                            kMaxLevel, text.substr(0, kMostAttributesNamed)));
  return range;
}

std::string LevelRange::to_text() const {
  return first == last       ? std::to_string(first)
         : last == kMaxLevel ? fmt::format("{}-", first)
                             : fmt::format("{}-{}", first, last);
}

LevelPipelines::LevelPipelines(std::string_view pipeline) : general_(pipeline) {
  of_level_.fill(general_);
}

LevelPipelines LevelPipelines::parse(std::string_view text) {
  const std::string_view whole = text;
  LevelPipelines pipelines(take_until(text, ';'));
  int next = 0;
  for (bool more = pipelines.general_.size() < whole.size(); more;) {
    more = text.find(';') != std::string_view::npos;
    std::string_view pipeline = take_until(text, ';');
    const std::string_view levels = take_until(pipeline, '=');
    const auto refuse = [&](std::string_view expected) {
      return Error(ErrorCode::kInvalidArgument,
                   fmt::format("choose the pipelines of levels: expected {}, found \"{}\"",
                               expected, whole.substr(0, kMostAttributesNamed)));
    };
    if (!levels.starts_with('@') || pipeline.empty())
      throw refuse("PIPELINE;@LEVELS=PIPELINE such as lz4;@1-3=zstd:9");
    const LevelRange range = LevelRange::parse(levels.substr(1));
    if (range.first < next) throw refuse("ranges of levels in ascending order that do not overlap");
    next = range.last + 1;
    pipelines.set(range, pipeline);
  }
  return pipelines;
}

void LevelPipelines::set(const LevelRange& levels, std::string_view pipeline) {
  for (int level = levels.first; level <= levels.last; ++level)
    of_level_[static_cast<std::size_t>(level)] = pipeline;
}

std::vector<LevelPipelines::Range> LevelPipelines::ranges() const {
  std::vector<Range> ranges;
  for (int level = 0; level <= kMaxLevel; ++level) {
    const std::string& pipeline = of(level);
    if (pipeline == general_) continue;
    if (!ranges.empty() && ranges.back().levels.last + 1 == level &&
        *ranges.back().pipeline == pipeline)
      ranges.back().levels.last = level;
    else
      ranges.push_back({{level, level}, &pipeline});
  }
  return ranges;
}

std::vector<std::string> LevelPipelines::all() const {
  std::vector<std::string> pipelines = {general_};
  for (const Range& range : ranges()) pipelines.push_back(*range.pipeline);
  return pipelines;
}

LevelPipelines LevelPipelines::changed(
    const std::function<std::string(std::string_view)>& change) const {
  LevelPipelines result(change(general_));
  for (const Range& range : ranges()) result.set(range.levels, change(*range.pipeline));
  return result;
}

std::string LevelPipelines::to_text() const {
  std::string text = general_;
  for (const Range& range : ranges())
    text += fmt::format(";@{}={}", range.levels.to_text(), *range.pipeline);
  return text;
}

PLAIT_END_NAMESPACE
