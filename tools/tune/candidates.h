// tools/tune/candidates.h: the pipelines that are tried.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "plait/attribute.h"
#include "plait/backends/pipeline.h"

namespace plait::tune {

/// Pipelines for records of this type, from the codecs and filters of `registry`, those of plug-ins
/// too. "none" and the presets come first. Then each codec alone and after each chain of filters:
/// `shuffle`, `shuffle+bytedelta`, each other filter alone and with `shuffle` behind it. Pipelines
/// that refuse the type, or that do the same as an earlier one, are left out.
///
/// `is_made`: a scheme makes such levels again, so the presets and a few others come with the stage
/// `predicted` too, without a recipe. `step`: the records were rounded to its multiples, so each
/// pipeline comes with filters that count in steps too. No candidate rounds anything by itself.
std::vector<std::string> candidate_pipelines(const PipelineRegistry& registry,
                                             const AttributeSchema& schema, bool is_made = false,
                                             std::optional<double> step = {});

/// The sizes of blocks that are tried: 64 KiB, 256 KiB, 1 MiB, and the store's own one.
std::vector<std::uint64_t> candidate_block_sizes(std::uint64_t own_block_bytes);

}  // namespace plait::tune
