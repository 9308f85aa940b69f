#include "plait/block_maker.h"

#include <algorithm>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The end of the first filter in the pipeline; 0 if the pipeline is a codec alone.
std::size_t first_filter_end(std::string_view pipeline) {
  const std::size_t comma = pipeline.find(',');
  if (comma == std::string_view::npos) return 0;
  return std::min(comma, pipeline.find('+'));
}

}  // namespace

bool has_predicted_stage(std::string_view pipeline) noexcept {
  const std::string_view first = pipeline.substr(0, first_filter_end(pipeline));
  return first.substr(0, first.find(':')) == kPredictedStage;
}

std::string_view recipe_in(std::string_view pipeline) noexcept {
  if (!has_predicted_stage(pipeline)) return {};
  const std::string_view first = pipeline.substr(0, first_filter_end(pipeline));
  const std::size_t colon = first.find(':');
  return colon == std::string_view::npos ? std::string_view() : first.substr(colon + 1);
}

std::string with_recipe(std::string_view pipeline, std::string_view recipe) {
  if (!has_predicted_stage(pipeline)) return std::string(pipeline);
  std::string result(kPredictedStage);
  if (!recipe.empty()) result.append(":").append(recipe);
  return result.append(pipeline.substr(first_filter_end(pipeline)));
}

std::string without_predicted_stage(std::string_view pipeline) {
  if (!has_predicted_stage(pipeline)) return std::string(pipeline);
  return std::string(pipeline.substr(first_filter_end(pipeline) + 1));
}

PLAIT_END_NAMESPACE
