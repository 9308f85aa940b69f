#include "plait/derivation.h"

#include <algorithm>

PLAIT_BEGIN_PRIVATE_NAMESPACE

bool is_derived(std::string_view pipeline) noexcept {
  return pipeline.substr(0, pipeline.find(':')) == kDerived;
}

std::string_view derivation_in(std::string_view pipeline) noexcept {
  const std::size_t colon = pipeline.find(':');
  return is_derived(pipeline) && colon != std::string_view::npos ? pipeline.substr(colon + 1)
                                                                 : std::string_view();
}

std::string derived_pipeline(std::string_view derivation) {
  return std::string(kDerived).append(":").append(derivation);
}

LevelGeometry derived_geometry(const SlotShapes& shapes, int refinements, int finest,
                               std::size_t record_bytes, std::uint64_t block_bytes) {
  // A slot has four times the bytes on the next level.
  const int coarser = std::clamp(finest - refinements, 0, 31);
  return {shapes, BaseRelativeLevel(refinements), record_bytes,
          std::max<std::uint64_t>(block_bytes >> (2 * coarser), 1)};
}

PLAIT_END_NAMESPACE
