#include "store/attribute_levels.h"

#include <utility>

#include "plait/extend/pipeline.h"
#include "plait/extend/store_access.h"
#include "store/store_state.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

LevelPipelines pipelines_of_levels(const Store& store, AttributeId attribute) {
  const int finest = store.attributes()[attribute].finest_level;
  if (finest == store.base_level()) return *store.options().pipeline;
  LevelPipelines pipelines = StoreAccess::level_file(store, attribute, finest).pipeline;
  for (int level = store.base_level() + 1; level < finest; ++level)
    pipelines.set({level, level}, StoreAccess::level_file(store, attribute, level).pipeline);
  return pipelines;
}

const LevelPipelines& named_pipelines(const Store& store, AttributeId attribute) {
  return StoreAccess::state(store).attributes[attribute].named_pipelines();
}

std::uint64_t bytes_of_levels(const Store& store, AttributeId attribute) {
  std::uint64_t bytes = 0;
  for (int level = store.base_level() + 1; level <= store.attributes()[attribute].finest_level;
       ++level)
    bytes += StoreAccess::level_file(store, attribute, level).geometry.total_bytes();
  return bytes;
}

PLAIT_END_NAMESPACE
