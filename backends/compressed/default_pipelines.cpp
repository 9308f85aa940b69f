#include <memory>
#include <string_view>

#include "compressed/codecs/built_in_codecs.h"
#include "compressed/filters/built_in_filters.h"
#include "plait/registry.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

PipelineRegistry built_in() {
  PipelineRegistry registry;
  registry.add(RegisteredCodec{"none", "copies", make_none_codec});
  registry.add(RegisteredCodec{"lz4", "fast to encode and to decode", make_lz4_codec});
  registry.add(RegisteredCodec{"bitpack",
                               "after a filter that predicts: no more bits than the numbers have",
                               make_bitpack_codec});
  registry.add(RegisteredCodec{"zstd", "smaller, slower to encode; zstd:LEVEL chooses a level",
                               make_zstd_codec});
  registry.add(RegisteredFilter{
      "shuffle", "groups the bytes of numbers by significance",
      [](std::string_view options, const FilterLevel& level) -> std::unique_ptr<Filter> {
        refuse_options("shuffle", options);
        const std::size_t width = component_bytes(level.schema.type);
        return width > 1 ? make_shuffle_filter(width) : nullptr;
      }});
  registry.add(RegisteredFilter{
      "hierarchy",
      "predicts vertices from the coarser levels; hierarchy:RULE by one rule for all blocks, "
      "hierarchy:along also along normals",
      make_hierarchy_filter});
  registry.add(RegisteredFilter{
      "normals", "predicts unit normals from positions; normals:NAME names their attribute",
      make_normals_filter});
  registry.add(RegisteredFilter{"columns",
                                "predicts floating-point numbers from the two above them in a slot",
                                make_columns_filter});
  registry.add(RegisteredFilter{"lattice",
                                "lattice:STEP: numbers that --max-error rounded, as small integers",
                                make_lattice_filter});
  registry.set_block_makers(library_block_makers());
  return registry;
}

}  // namespace

const PipelineRegistry& default_pipelines() {
  static const PipelineRegistry registry = built_in();
  return registry;
}

PLAIT_END_NAMESPACE
