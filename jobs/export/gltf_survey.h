// export/gltf_survey.h: what has to be known of the records before a glTF file is begun.
#pragma once

#include <cstdint>

#include "export/gltf_document.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct GltfSurvey {
  std::uint64_t normals_without_direction = 0;  ///< zero, infinite or not a number
  std::uint64_t normals_scaled = 0;             ///< of another length than 1
  std::uint64_t colors_clamped = 0;             ///< with a number that is not from 0 to 1
};

/// Reads the records of the columns, each vertex once, and sets translation and step of
/// `placement`. Errors: kInvalidArgument for a number that float32 or JSON cannot have: glTF files
/// have finite numbers only.
GltfSurvey survey(const ExportTask& task, std::span<const GltfColumn> columns,
                  GltfPlacement& placement);

PLAIT_END_NAMESPACE
