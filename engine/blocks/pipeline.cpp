#include "plait/extend/pipeline.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "base/text.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

[[noreturn]] void refuse_text(std::string_view what, std::string_view expected,
                              std::string_view text) {
  throw Error(ErrorCode::kInvalidArgument, fmt::format("choose {}: expected {}, found \"{}\"", what,
                                                       expected, text_for_message(text)));
}

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

/// A stage of `pipeline`.
PipelineStage stage_of(std::string_view text, std::string_view pipeline) {
  const std::string_view name = text.substr(0, text.find(':'));
  if (!is_stage_name(name))
    refuse_text("a pipeline", "[FILTER+FILTER,]CODEC such as shuffle,zstd:1", pipeline);
  if (name.size() + 1 == text.size())
    refuse_text("a pipeline", "options after the colon", pipeline);
  if (!std::ranges::all_of(text, [](char c) { return c >= ' ' && c <= '~'; }))
    refuse_text("a pipeline", "printable ASCII characters", pipeline);
  return {std::string(name), std::string(text.substr(std::min(name.size() + 1, text.size())))};
}

}  // namespace

bool is_stage_name(std::string_view name) noexcept {
  return !name.empty() && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-';
  });
}

std::string PipelineStage::to_text() const {
  return options.empty() ? name : fmt::format("{}:{}", name, options);
}

Pipeline Pipeline::parse(std::string_view text) {
  if (text.find(';') != std::string_view::npos)
    refuse_text("a pipeline", "one pipeline and none for ranges of levels", text);
  Pipeline pipeline;
  const std::size_t comma = text.find(',');
  if (comma != std::string_view::npos)
    for (std::string_view rest = text.substr(0, comma);;) {
      const bool is_last = rest.find('+') == std::string_view::npos;
      PipelineStage stage = stage_of(take_until(rest, '+'), text);
      if (stage.name != kPredictedStage)
        pipeline.filters.push_back(std::move(stage));
      else if (pipeline.filters.empty() && !pipeline.recipe)
        pipeline.recipe = std::move(stage.options);
      else
        refuse_text("a pipeline", "the stage predicted once, before all filters", text);
      if (is_last) break;
    }
  pipeline.codec = stage_of(comma == std::string_view::npos ? text : text.substr(comma + 1), text);
  return pipeline;
}

std::string Pipeline::to_text() const {
  std::string text;
  if (recipe) text = PipelineStage{std::string(kPredictedStage), *recipe}.to_text();
  for (const PipelineStage& filter : filters) {
    if (!text.empty()) text += '+';
    text += filter.to_text();
  }
  if (!text.empty()) text += ',';
  return text + codec.to_text();
}

Pipeline Pipeline::with_recipe(std::string_view other) const {
  Pipeline changed = *this;
  if (changed.recipe) changed.recipe = other;
  return changed;
}

Pipeline Pipeline::without_predicted_stage() const {
  Pipeline changed = *this;
  changed.recipe.reset();
  // In text without a filter, a comma in the codec's options would end the filters.
  if (changed.filters.empty() && changed.codec.options.find(',') != std::string::npos)
    changed.filters.push_back({"none", {}});
  return changed;
}

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
    refuse_text("levels", fmt::format("levels of 0 to {} such as 4, 1-3 or 6-", kMaxLevel), text);
  return range;
}

std::string LevelRange::to_text() const {
  return first == last       ? std::to_string(first)
         : last == kMaxLevel ? fmt::format("{}-", first)
                             : fmt::format("{}-{}", first, last);
}

LevelPipelines LevelPipelines::parse(std::string_view text) {
  constexpr std::string_view kWhat = "the pipelines of levels";
  std::string_view rest = text;
  bool more = text.find(';') != std::string_view::npos;
  LevelPipelines pipelines = Pipeline(take_until(rest, ';'));
  for (int next = 0; more;) {
    more = rest.find(';') != std::string_view::npos;
    std::string_view pipeline = take_until(rest, ';');
    const std::string_view levels = take_until(pipeline, '=');
    if (!levels.starts_with('@') || pipeline.empty())
      refuse_text(kWhat, "PIPELINE;@LEVELS=PIPELINE such as lz4;@1-3=zstd:9", text);
    const LevelRange range = LevelRange::parse(levels.substr(1));
    if (range.first < next)
      refuse_text(kWhat, "ranges of levels in ascending order that do not overlap", text);
    next = range.last + 1;
    pipelines.set(range, Pipeline(pipeline));
  }
  return pipelines;
}

void LevelPipelines::set(const LevelRange& levels, const Pipeline& pipeline) {
  for (int level = levels.first; level <= levels.last; ++level) others_[level] = pipeline;
  normalize();
}

void LevelPipelines::normalize() {
  std::erase_if(others_, [this](const auto& other) { return other.second == general_; });
}

const Pipeline& LevelPipelines::of(int level) const {
  const auto other = others_.find(level);
  return other == others_.end() ? general_ : other->second;
}

std::string LevelPipelines::to_text() const {
  std::string text = general_.to_text();
  for (auto at = others_.begin(); at != others_.end();) {
    const auto& [first, pipeline] = *at;
    int end = first;
    for (; at != others_.end() && at->first == end && at->second == pipeline; ++at) ++end;
    text += fmt::format(";@{}={}", LevelRange{first, end - 1}.to_text(), pipeline.to_text());
  }
  return text;
}

PLAIT_END_NAMESPACE
