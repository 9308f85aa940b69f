// bench/tune/candidates.h: the pipelines that are tried.
#pragma once

#include <optional>
#include <vector>

#include "plait/attribute.h"
#include "plait/extend/pipeline_registry.h"

namespace plait::tune {

/// Pipelines for records of this type, from the codecs and filters of `registry`, those of plug-ins
/// too. "none" and the presets come first. Then each codec alone and after each chain of filters:
/// `shuffle`, each other filter alone and with `shuffle` behind it. Pipelines
/// that refuse the type, or that do the same as an earlier one, are left out.
///
/// `step`: the records were rounded to its multiples, so each pipeline comes with filters that
/// count in steps too. No candidate rounds anything by itself, and none has the stage `predicted`.
std::vector<Pipeline> candidate_pipelines(const PipelineRegistry& registry,
                                          const AttributeSchema& schema,
                                          std::optional<double> step = {});

}  // namespace plait::tune
