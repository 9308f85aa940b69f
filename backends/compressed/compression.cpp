#include "plait/backends/compression.h"

#include <fmt/format.h>

#include <algorithm>

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

}  // namespace

const std::vector<CompressionPreset>& compression_presets() {
  static const std::vector<CompressionPreset> presets = {
      {"fast", "vertices predicted inside their slots; little processor time"},
      {"default", "vertices predicted from coarser levels; what a scheme has made takes no bytes"},
      {"small", "the same, with a slower codec"},
      {"none", "blocks as they are, in a store that can hold compressed ones too"}};
  return presets;
}

std::string preset_pipeline(std::string_view preset, const AttributeSchema& schema) {
  const std::string_view filters = is_normal(schema)          ? "normals+shuffle"
                                   : can_be_predicted(schema) ? "hierarchy+shuffle"
                                                              : "shuffle";
  if (preset == "fast")
    return can_be_predicted(schema) ? "parallelogram+shuffle,lz4" : "shuffle,lz4";
  const std::string_view stage = is_made_by_schemes(schema) ? "predicted+" : "";
  if (preset == "default") return fmt::format("{}{},zstd:1", stage, filters);
  if (preset == "small") return fmt::format("{}{},zstd:9", stage, filters);
  if (preset == "none") return "none";
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("choose compression: expected fast, default, small or none, found \"{}\"",
                          preset));
}

std::string pipeline_of_rounded(std::string_view pipeline, double step) {
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
      add(filter.find("midpoint") != std::string_view::npos
              ? fmt::format("hierarchy:midpoint:step={}", text)
              : fmt::format("hierarchy:step={}", text));
    else if (name == "parallelogram")
      add(fmt::format("lattice:{}+lorenzo", text));
    else if (name == "lattice")
      add(fmt::format("lattice:{}", text));
    else if (name != "predicted")  // no scheme makes rounded records
      add(filter);
  }
  if (made.empty()) return std::string(pipeline.substr(comma + 1));
  return made += pipeline.substr(comma);
}

void Compression::add(std::string_view text) {
  // An option of a filter or of a codec comes after a colon and may have an equals sign of its own.
  const std::size_t equals = text.find('=');
  const bool names_attribute =
      equals != std::string_view::npos && equals < text.find_first_of(":,+");
  const std::string_view attribute = names_attribute ? text.substr(0, equals) : std::string_view();
  const std::string_view pipeline = names_attribute ? text.substr(equals + 1) : text;
  if (pipeline.empty() || (names_attribute && attribute.empty()))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("choose compression: expected a preset, a pipeline or "
                            "ATTRIBUTE=PIPELINE, found \"{}\"",
                            text));
  if (names_attribute)
    of_attribute_.insert_or_assign(std::string(attribute), std::string(pipeline));
  else
    general_ = pipeline;
}

std::string Compression::pipeline_of(const AttributeSchema& schema) const {
  const auto own = of_attribute_.find(schema.name);
  const std::string_view text = own != of_attribute_.end() ? std::string_view(own->second)
                                : general_.empty()         ? std::string_view("default")
                                                           : std::string_view(general_);
  return is_preset(text) ? preset_pipeline(text, schema) : std::string(text);
}

PLAIT_END_NAMESPACE
