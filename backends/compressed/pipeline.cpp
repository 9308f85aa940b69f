#include "plait/backends/pipeline.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "compressed/codecs/built_in_codecs.h"
#include "compressed/filters/byte_delta_filter.h"
#include "compressed/filters/columns_filter.h"
#include "compressed/filters/hierarchy_filter.h"
#include "compressed/filters/lattice_filter.h"
#include "compressed/filters/lorenzo_filter.h"
#include "compressed/filters/normals_filter.h"
#include "compressed/filters/parallelogram_filter.h"
#include "compressed/filters/shuffle_filter.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// One stage of the pipeline string.
struct Stage {
  std::string_view name, options;
};

Stage split_options(std::string_view text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos) return {text, {}};
  if (colon + 1 == text.size())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("choose \"{}\": expected options after the colon", text));
  return {text.substr(0, colon), text.substr(colon + 1)};
}

struct Parts {
  std::string_view filters, codec;
};

Parts parts_of(std::string_view pipeline) {
  const std::size_t comma = pipeline.find(',');
  if (comma == std::string_view::npos) return {{}, pipeline};
  return {pipeline.substr(0, comma), pipeline.substr(comma + 1)};
}

bool is_name(std::string_view name) {
  return !name.empty() && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-';
  });
}

template <class Entries>
std::vector<std::string> names_of(const Entries& entries) {
  std::vector<std::string> names;
  names.reserve(entries.size());
  for (const auto& [name, entry] : entries) names.push_back(name);
  return names;
}

template <class Entries, class Entry>
void add_to(Entries& entries, const char* kind, Entry entry) {
  const std::string name = entry.name;
  const char* const fault = !is_name(name) ? "the name has only characters of [A-Za-z0-9_-]"
                            : !entry.make  ? "`make` is not empty"
                            : entries.contains(name) ? "the name is new"
                                                     : nullptr;
  if (fault)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("register {} \"{}\": expected that {}", kind, name, fault));
  entries.emplace(name, std::move(entry));
}

template <class Entries>
const auto& find_in(const Entries& entries, const char* kind, const Stage& stage,
                    std::string_view pipeline) {
  const auto found = entries.find(stage.name);
  if (found != entries.end()) return found->second;
  throw Error(ErrorCode::kNotSupported,
              fmt::format("choose {} \"{}\" of pipeline \"{}\": expected one of {}; plug-ins add "
                          "others (--plugin FILE, PLAIT_PLUGINS)",
                          kind, stage.name, pipeline, fmt::join(names_of(entries), ", ")));
}

PipelineRegistry built_in() {
  PipelineRegistry registry;
  registry.add(PipelineRegistry::CodecEntry{"none", "copies", make_none_codec});
  registry.add(PipelineRegistry::CodecEntry{"lz4", "fast to encode and to decode", make_lz4_codec});
  registry.add(PipelineRegistry::CodecEntry{
      "bitpack", "after a filter that predicts: no more bits than the numbers have",
      make_bitpack_codec});
  registry.add(PipelineRegistry::CodecEntry{
      "zstd",
      "smaller, slower to encode; zstd:LEVEL chooses a level, zstd:huffman only codes bytes",
      make_zstd_codec});
  registry.add(PipelineRegistry::FilterEntry{
      "shuffle", "groups the bytes of numbers by significance",
      [](std::string_view options, const FilterLevel& level) -> std::unique_ptr<Filter> {
        refuse_options("shuffle", options);
        const std::size_t width = component_bytes(level.schema.type);
        return width > 1 ? make_shuffle_filter(width) : nullptr;
      }});
  registry.add(PipelineRegistry::FilterEntry{
      "hierarchy",
      "predicts vertices from the coarser levels; hierarchy:RULE by one rule for all blocks",
      make_hierarchy_filter});
  registry.add(PipelineRegistry::FilterEntry{
      "normals", "predicts unit normals from positions; normals:NAME names their attribute",
      make_normals_filter});
  registry.add(PipelineRegistry::FilterEntry{
      "bytedelta", "after shuffle: differences of bytes that follow each other in a group",
      make_byte_delta_filter});
  registry.add(PipelineRegistry::FilterEntry{
      "columns", "predicts floating-point numbers from the two above them in a slot",
      make_columns_filter});
  registry.add(PipelineRegistry::FilterEntry{
      "lattice", "lattice:STEP: numbers that --max-error rounded, as small integers",
      make_lattice_filter});
  registry.add(PipelineRegistry::FilterEntry{
      "lorenzo", "differences along the rows of a slot and across them", make_lorenzo_filter});
  registry.add(PipelineRegistry::FilterEntry{
      "parallelogram", "predicts floating-point numbers from their neighbours in a slot",
      make_parallelogram_filter});
  registry.set_block_makers(library_block_makers());
  return registry;
}

/// Sets the maker of a level, or the reason why there is none.
void make_maker(const BlockMakers* makers, std::string_view recipe, const FilterLevel& level,
                Pipeline& made) {
  if (recipe.empty() || level.geometry == nullptr || level.surroundings == nullptr) {
    made.why_no_maker = "the level has no recipe";
  } else if (makers == nullptr) {
    made.why_no_maker = "this program has nothing that makes blocks again";
  } else {
    // A store with a scheme that nobody here knows can be opened; its other blocks can be read.
    try {
      made.maker = makers->open({recipe, level.schema, *level.geometry, level.surroundings->mesh,
                                 level.surroundings->positions});
      made.why_no_maker = fmt::format("recipe {} does not make this level", recipe);
    } catch (const Error& error) {
      made.why_no_maker = error.what();
    }
  }
}

}  // namespace

void PipelineRegistry::add(CodecEntry entry) { add_to(codecs_, "codec", std::move(entry)); }

void PipelineRegistry::add(FilterEntry entry) {
  if (entry.name == kPredictedStage)
    throw Error(
        ErrorCode::kInvalidArgument,
        "register filter \"predicted\": expected another name: it has a meaning of its own");
  if (entry.name == "none")
    throw Error(ErrorCode::kInvalidArgument,
                "register filter \"none\": expected another name: none stands for no filter");
  add_to(filters_, "filter", std::move(entry));
}

std::vector<std::string> PipelineRegistry::codec_names() const { return names_of(codecs_); }
std::vector<std::string> PipelineRegistry::filter_names() const { return names_of(filters_); }

Pipeline PipelineRegistry::make(std::string_view pipeline, const FilterLevel& level) const {
  Pipeline made;
  std::string_view filters = parts_of(pipeline).filters;
  for (bool more = pipeline.find(',') != std::string_view::npos; more;) {
    const std::size_t plus = filters.find('+');
    more = plus != std::string_view::npos;
    const Stage stage = split_options(filters.substr(0, plus));
    if (more) filters.remove_prefix(plus + 1);
    if (stage.name == "none" && stage.options.empty()) continue;
    if (stage.name == kPredictedStage && made.why_no_maker.empty() && made.filters.empty()) {
      make_maker(makers_.get(), stage.options, level, made);
      continue;
    }
    auto filter = find_in(filters_, "filter", stage, pipeline).make(stage.options, level);
    if (!filter) continue;
    if (!made.filters.empty() && (filter->needs_other_blocks() || filter->keeps_note()))
      throw Error(ErrorCode::kNotSupported,
                  fmt::format("choose pipeline \"{}\": expected filter {} in the first place, "
                              "because it needs other blocks or keeps a note",
                              pipeline, stage.name));
    made.filters.push_back(std::move(filter));
  }
  made.codec = make_codec(pipeline);
  return made;
}

std::unique_ptr<Codec> PipelineRegistry::make_codec(std::string_view pipeline) const {
  const Stage codec = split_options(parts_of(pipeline).codec);
  return find_in(codecs_, "codec", codec, pipeline).make(codec.options);
}

const PipelineRegistry& default_pipelines() {
  static const PipelineRegistry registry = built_in();
  return registry;
}

PLAIT_END_NAMESPACE
