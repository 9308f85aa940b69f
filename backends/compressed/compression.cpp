#include "plait/compression.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "base/text.h"
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

/// The rule that the options of a filter `hierarchy` name, and a colon; empty if they name none.
std::string_view rule_of(const PipelineStage& filter) {
  if (filter.name == "hierarchy")
    for (const std::string_view rule : {"butterfly:", "loop:", "midpoint:"})
      if (filter.options.find(rule.substr(0, rule.size() - 1)) != std::string::npos) return rule;
  return {};
}

void count_in_steps(Pipeline& pipeline, double step) {
  // A plus sign would end the filter.
  std::string text = fmt::format("{}", step);
  std::erase(text, '+');
  std::vector<PipelineStage> filters;
  bool counts = false;  // `lattice` came
  for (const PipelineStage& filter : pipeline.filters)
    if (filter.name == "hierarchy" || filter.name == "normals") {
      filters.push_back({"hierarchy", fmt::format("{}step={}", rule_of(filter), text)});
    } else if (filter.name == "lattice") {
      filters.push_back({"lattice", text});
      counts = true;
    } else {
      if (filter.name == "columns" && !counts) filters.push_back({"lattice", text});
      filters.push_back(filter);
    }
  pipeline.filters = std::move(filters);
  pipeline = pipeline.without_predicted_stage();  // no scheme makes rounded records
}

int level_count(const LevelRange& levels) { return levels.last - levels.first + 1; }

}  // namespace

const std::vector<CompressionPreset>& compression_presets() {
  static const std::vector<CompressionPreset> presets = {
      {"fast", "vertices predicted inside their slots; little processor time"},
      {"default", "vertices predicted from coarser levels; what can be made again takes no bytes"},
      {"small", "the same with a slower codec"},
      {"none", "blocks as they are, in a store that can hold compressed ones too"}};
  return presets;
}

Pipeline preset_pipeline(std::string_view preset, const AttributeSchema& schema) {
  if (preset == "none") return {};
  const bool is_predicted = can_be_predicted(schema);
  // `bitpack` packs words of 32 bits, and no others.
  const bool is_packed = is_predicted && schema.type == ComponentType::kFloat32;
  if (preset == "fast")
    return is_packed ? "columns,bitpack" : is_predicted ? "columns+shuffle,lz4" : "shuffle,lz4";
  if (preset != "default" && preset != "small")
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("choose compression: expected fast, default, small or none, found \"{}\"",
                    text_for_message(preset)));
  Pipeline pipeline;
  if (is_made_by_schemes(schema)) pipeline.recipe = "";
  const bool is_along_normals = preset == "small" && schema.components == 3;
  if (is_normal(schema))
    pipeline.filters.push_back({"normals"});
  else if (is_predicted)
    pipeline.filters.push_back({"hierarchy", is_along_normals ? "along" : ""});
  if (preset == "default" && is_packed) {
    pipeline.codec = {"bitpack"};
  } else {
    pipeline.filters.push_back({"shuffle"});
    pipeline.codec = {"zstd", preset == "default" ? "1" : "9"};
  }
  return pipeline;
}

LevelPipelines pipeline_of_rounded(LevelPipelines pipelines, double step) {
  pipelines.for_each([step](Pipeline& pipeline) { count_in_steps(pipeline, step); });
  return pipelines;
}

void Compression::add(std::string_view text) {
  // An option of a filter or of a codec comes after a colon and may have an equals sign of its own.
  const std::size_t equals = text.find('='), stage_end = text.find_first_of(":,+");
  const bool is_for_some = equals != std::string_view::npos && equals < stage_end;
  const std::string_view target = is_for_some ? text.substr(0, equals) : std::string_view();
  const std::string_view chosen = is_for_some ? text.substr(equals + 1) : text;
  const std::size_t at = target.find('@');
  const auto refuse = [text](std::string_view reason) {
    return Error(ErrorCode::kInvalidArgument,
                 fmt::format("choose compression: expected a preset, a pipeline or "
                             "[ATTRIBUTE][@LEVELS]=PIPELINE, found \"{}\"{}",
                             text_for_message(text), reason));
  };
  if (chosen.empty() || (is_for_some && target.empty())) throw refuse("");
  if (text.substr(0, stage_end).find('@') != std::string_view::npos && !is_for_some)
    throw refuse(": no pipeline follows the levels");
  if (chosen.find(';') != std::string_view::npos)
    throw refuse(": give each range of levels a text of its own");
  Choice choice;
  choice.attribute = target.substr(0, at);
  if (at != std::string_view::npos) choice.levels = LevelRange::parse(target.substr(at + 1));
  if (is_preset(chosen))
    choice.preset = chosen;
  else
    choice.pipeline = chosen;
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
                              choice.attribute.empty() ? "all attributes"
                                                       : text_for_message(choice.attribute),
                              other.levels.to_text(), choice.levels.to_text()));
  std::erase_if(choices_, is_same);
  const auto place = std::ranges::find_if(choices_, [&](const Choice& other) {
    return other.attribute.empty() != choice.attribute.empty()
               ? choice.attribute.empty()
               : level_count(other.levels) < level_count(choice.levels);
  });
  choices_.insert(place, std::move(choice));
}

LevelPipelines Compression::pipeline_of(const AttributeSchema& schema) const {
  LevelPipelines pipelines = preset_pipeline("default", schema);
  for (const Choice& choice : choices_) {
    if (!choice.attribute.empty() && choice.attribute != schema.name) continue;
    const Pipeline chosen =
        choice.preset.empty() ? choice.pipeline : preset_pipeline(choice.preset, schema);
    if (choice.levels == LevelRange())
      pipelines = chosen;
    else
      pipelines.set(choice.levels, chosen);
  }
  return pipelines;
}

void Compression::check_attributes(const std::vector<std::string>& names) const {
  for (const Choice& choice : choices_)
    if (!choice.attribute.empty() && std::ranges::find(names, choice.attribute) == names.end())
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("choose compression of attribute '{}': expected one of {}",
                              text_for_message(choice.attribute), fmt::join(names, ", ")));
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
