#include "plait/backends/compression.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

bool is_preset(std::string_view text) {
  return std::ranges::find(compression_presets(), text, &CompressionPreset::name) !=
         compression_presets().end();
}

bool can_be_predicted(const AttributeSchema& schema) {
  return (schema.type == ComponentType::kFloat32 || schema.type == ComponentType::kFloat64) &&
         schema.components <= 4;
}

/// By the name that the library itself gives to normals.
bool is_normal(const AttributeSchema& schema) {
  return schema.name == "normal" && schema.type == ComponentType::kFloat32 &&
         schema.components == 3;
}

/// By the names that the library itself gives. The stage `predicted` makes nothing of others.
bool is_made_by_schemes(const AttributeSchema& schema) {
  return is_normal(schema) ||
         (schema.name == "position" && schema.components == 3 && can_be_predicted(schema));
}

/// The rule of a filter `hierarchy`, and a colon; empty if it names none.
std::string_view rule_of(std::string_view filter) {
  if (!filter.starts_with("hierarchy:")) return {};
  for (const std::string_view rule : {"butterfly:", "loop:", "midpoint:"})
    if (filter.find(rule.substr(0, rule.size() - 1)) != std::string_view::npos) return rule;
  return {};
}

/// The pipeline of one level.
std::string with_step(std::string_view pipeline, double step) {
  const std::size_t comma = pipeline.find(',');
  if (comma == std::string_view::npos) return std::string(pipeline);
  // A plus sign would end the filter.
  std::string text = fmt::format("{}", step);
  std::erase(text, '+');
  std::string made;
  const auto add = [&](std::string_view filter) {
    if (!made.empty()) made += '+';
    made += filter;
  };
  for (std::string_view filters = pipeline.substr(0, comma); !filters.empty();) {
    const std::string_view filter = filters.substr(0, filters.find('+'));
    filters.remove_prefix(std::min(filter.size() + 1, filters.size()));
    const std::string_view name = filter.substr(0, filter.find(':'));
    if (name == "hierarchy" || name == "normals")
      add(fmt::format("hierarchy:{}step={}", rule_of(filter), text));
    else if (name == "parallelogram" || name == "columns")
      add(fmt::format("lattice:{}+lorenzo", text));
    else if (name == "lattice")
      add(fmt::format("lattice:{}", text));
    else if (name != "predicted")  // no scheme makes rounded records
      add(filter);
  }
  if (made.empty()) return std::string(pipeline.substr(comma + 1));
  return made += pipeline.substr(comma);
}

int level_count(const LevelRange& levels) { return levels.last - levels.first + 1; }

}  // namespace

const std::vector<CompressionPreset>& compression_presets() {
  static const std::vector<CompressionPreset> presets = {
      {"fast", "vertices predicted inside their slots; little processor time"},
      {"default", "vertices predicted from coarser levels; what a scheme has made takes no bytes"},
      {"small", "the same, with a slower codec that takes fewer bytes"},
      {"none", "blocks as they are, in a store that can hold compressed ones too"}};
  return presets;
}

std::string preset_pipeline(std::string_view preset, const AttributeSchema& schema) {
  if (preset == "none") return "none";
  const bool is_predicted = can_be_predicted(schema);
  // `bitpack` packs words of 32 bits, and no others.
  const bool is_packed = is_predicted && schema.type == ComponentType::kFloat32;
  if (preset == "fast")
    return is_packed      ? "columns,bitpack"
           : is_predicted ? "parallelogram+shuffle,lz4"
                          : "shuffle,lz4";
  const std::string_view stage = is_made_by_schemes(schema) ? "predicted+" : "";
  const std::string_view filter = is_normal(schema) ? "normals"
                                  : is_predicted    ? "hierarchy"
                                                    : "shuffle";
  const std::string_view grouped = is_predicted ? "+shuffle" : "";
  if (preset == "default")
    return is_packed ? fmt::format("{}{},bitpack", stage, filter)
                     : fmt::format("{}{}{},zstd:1", stage, filter, grouped);
  if (preset == "small") return fmt::format("{}{}{},zstd:9", stage, filter, grouped);
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("choose compression: expected fast, default, small or none, found \"{}\"",
                          preset));
}

std::string pipeline_of_rounded(std::string_view pipeline, double step) {
  return LevelPipelines::parse(pipeline)
      .changed([step](std::string_view of_level) { return with_step(of_level, step); })
      .to_text();
}

void Compression::add(std::string_view text) {
  // An option of a filter or of a codec comes after a colon and may have an equals sign of its own.
  const std::size_t equals = text.find('='), stage_end = text.find_first_of(":,+");
  const bool is_for_some = equals != std::string_view::npos && equals < stage_end;
  const std::string_view target = is_for_some ? text.substr(0, equals) : std::string_view();
  const std::size_t at = target.find('@');
  Choice choice;
  choice.attribute = target.substr(0, at);
  choice.pipeline = is_for_some ? text.substr(equals + 1) : text;
  const auto refuse = [text](std::string_view reason) {
    return Error(ErrorCode::kInvalidArgument,
                 fmt::format("choose compression: expected a preset, a pipeline or "
                             "[ATTRIBUTE][@LEVELS]=PIPELINE, found \"{}\"{}",
                             text, reason));
  };
  if (choice.pipeline.empty() || (is_for_some && target.empty())) throw refuse("");
  if (text.substr(0, stage_end).find('@') != std::string_view::npos && !is_for_some)
    throw refuse(": no pipeline follows the levels");
  if (choice.pipeline.find(';') != std::string::npos)
    throw refuse(": give each range of levels a text of its own");
  if (at != std::string_view::npos) choice.levels = LevelRange::parse(target.substr(at + 1));
  put(std::move(choice));
}

void Compression::put(Choice choice) {
  const auto is_same = [&](const Choice& other) {
    return other.attribute == choice.attribute && other.levels == choice.levels;
  };
  for (const Choice& other : choices_)
    if (other.attribute == choice.attribute && other.levels.meets(choice.levels) &&
        !other.levels.contains(choice.levels) && !choice.levels.contains(other.levels))
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("choose compression of {}: expected ranges of levels that are apart "
                              "or one inside the other, found {} and {}",
                              choice.attribute.empty() ? "all attributes" : choice.attribute,
                              other.levels.to_text(), choice.levels.to_text()));
  std::erase_if(choices_, is_same);
  const auto place = std::ranges::find_if(choices_, [&](const Choice& other) {
    return other.attribute.empty() != choice.attribute.empty()
               ? choice.attribute.empty()
               : level_count(other.levels) < level_count(choice.levels);
  });
  choices_.insert(place, std::move(choice));
}

std::string Compression::pipeline_of(const AttributeSchema& schema) const {
  const auto pipeline = [&](std::string_view text) {
    return is_preset(text) ? preset_pipeline(text, schema) : std::string(text);
  };
  LevelPipelines pipelines(pipeline("default"));
  for (const Choice& choice : choices_) {
    if (!choice.attribute.empty() && choice.attribute != schema.name) continue;
    if (choice.levels == LevelRange())
      pipelines = LevelPipelines(pipeline(choice.pipeline));
    else
      pipelines.set(choice.levels, pipeline(choice.pipeline));
  }
  return pipelines.to_text();
}

void Compression::check_levels(int base_level, int finest_level) const {
  for (const Choice& choice : choices_) {
    const LevelRange& levels = choice.levels;
    if (levels == LevelRange()) continue;
    const bool ends_beyond = levels.last > finest_level && levels.last < kMaxLevel;
    if (levels.last > base_level && levels.first <= finest_level && !ends_beyond) continue;
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("choose compression of levels {}: expected levels from {} to {}{}{}",
                    levels.to_text(), base_level + 1, finest_level,
                    base_level > 0 && levels.last <= base_level
                        ? fmt::format(", because the vertices of levels 0 to {} are in the base "
                                      "mesh, which is not compressed",
                                      base_level)
                        : "",
                    ends_beyond && levels.first <= finest_level
                        ? fmt::format("; {}- are all levels from {}", levels.first, levels.first)
                        : ""));
  }
}

PLAIT_END_NAMESPACE
