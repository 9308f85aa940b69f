#include "plait/extend/pipeline_registry.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/text.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

template <class Registered>
std::vector<std::string> names_of(const Registered& registered) {
  std::vector<std::string> names;
  names.reserve(registered.size());
  for (const auto& [name, stage] : registered) names.push_back(name);
  return names;
}

template <class Registered, class Added>
void add_to(Registered& registered, const char* kind, Added added) {
  const std::string name = added.name;
  const char* const fault = !is_stage_name(name) ? "the name has only characters of [A-Za-z0-9_-]"
                            : !added.make        ? "`make` is not empty"
                            : registered.contains(name) ? "the name is new"
                                                        : nullptr;
  if (fault)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("register {} \"{}\": expected that {}", kind, name, fault));
  registered.emplace(name, std::move(added));
}

template <class Registered>
const auto& find_in(const Registered& registered, const char* kind, const PipelineStage& stage,
                    std::string_view pipeline) {
  const auto found = registered.find(stage.name);
  if (found != registered.end()) return found->second;
  throw Error(ErrorCode::kNotSupported,
              fmt::format("choose {} \"{}\" of pipeline \"{}\": expected one of {}; plug-ins add "
                          "others (--plugin FILE, PLAIT_PLUGINS)",
                          kind, text_for_message(stage.name), text_for_message(pipeline),
                          fmt::join(names_of(registered), ", ")));
}

/// Sets the maker of a level, or the reason why there is none.
void make_maker(const BlockMakers* makers, std::string_view recipe, const FilterLevel& level,
                OpenPipeline& made) {
  if (recipe.empty() || level.geometry == nullptr || level.surroundings == nullptr) {
    made.why_no_maker = "the level has no recipe";
  } else if (makers == nullptr) {
    made.why_no_maker = "this program has nothing that makes blocks again";
  } else {
    // A store with a scheme that nobody here knows can be opened; its other blocks can be read.
    try {
      made.maker = makers->open(
          {recipe, level.schema, level.attribute, *level.geometry, *level.surroundings});
      made.why_no_maker = fmt::format("recipe {} does not make this level", recipe);
    } catch (const Error& error) {
      made.why_no_maker = error.what();
    }
  }
}

/// The recipe for the pipeline's stage `predicted`; empty if the stage is not there or makes no
/// such levels.
std::string recipe_for(const BlockMakers* makers, const Pipeline& pipeline, PlannedLevels levels) {
  if (makers == nullptr || !pipeline.recipe) return {};
  const std::string& former = *pipeline.recipe;
  if (!former.empty() && !source_in(former)) levels.others_are_complete = false;
  return makers->recipe(levels);
}

}  // namespace

void PipelineRegistry::add(RegisteredCodec codec) { add_to(codecs_, "codec", std::move(codec)); }

void PipelineRegistry::add(RegisteredFilter filter) {
  if (filter.name == kPredictedStage || filter.name == "none")
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("register filter \"{}\": expected another name: it has a meaning of its "
                    "own",
                    filter.name));
  add_to(filters_, "filter", std::move(filter));
}

std::vector<std::string> PipelineRegistry::codec_names() const { return names_of(codecs_); }
std::vector<std::string> PipelineRegistry::filter_names() const { return names_of(filters_); }

OpenPipeline PipelineRegistry::open(const Pipeline& pipeline, const FilterLevel& level) const {
  OpenPipeline made;
  if (pipeline.recipe) make_maker(makers_.get(), *pipeline.recipe, level, made);
  for (const PipelineStage& stage : pipeline.filters) {
    if (stage == PipelineStage{"none", {}}) continue;
    auto filter = find_in(filters_, "filter", stage, pipeline.to_text()).make(stage.options, level);
    if (!filter) continue;
    if (!made.filters.empty() && (filter->needs_other_blocks() || filter->keeps_note()))
      throw Error(ErrorCode::kNotSupported,
                  fmt::format("choose pipeline \"{}\": expected filter {} in the first place, "
                              "because it needs other blocks or keeps a note",
                              text_for_message(pipeline.to_text()), stage.name));
    made.filters.push_back(std::move(filter));
  }
  made.codec =
      find_in(codecs_, "codec", pipeline.codec, pipeline.to_text()).make(pipeline.codec.options);
  return made;
}

std::unique_ptr<Codec> PipelineRegistry::make_codec(const PipelineStage& codec) const {
  return find_in(codecs_, "codec", codec, codec.to_text()).make(codec.options);
}

bool PipelineRegistry::needs_other_blocks(const Pipeline& pipeline,
                                          const AttributeSchema& schema) const {
  FilterLevel level;
  level.schema = schema;
  const OpenPipeline opened = open(pipeline, level);
  return (!opened.filters.empty() && opened.filters.front()->needs_other_blocks()) ||
         source_in(recipe_for(makers_.get(), pipeline, {schema, {}, 1, true}));
}

Pipeline PipelineRegistry::planned(const Pipeline& pipeline, PlannedLevels levels) const {
  const std::string recipe = recipe_for(makers_.get(), pipeline, std::move(levels));
  return recipe.empty() ? pipeline.without_predicted_stage() : pipeline.with_recipe(recipe);
}

PLAIT_END_NAMESPACE
