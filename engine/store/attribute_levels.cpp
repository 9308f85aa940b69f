#include "plait/attribute_levels.h"

#include "plait/level_pipelines.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

std::string pipelines_of_levels(const Store& store, AttributeId attribute) {
  const int finest = store.attributes()[attribute].finest_level;
  if (finest == store.base_level()) return store.options().pipeline;
  LevelPipelines pipelines(store.level_file(attribute, finest).pipeline);
  for (int level = store.base_level() + 1; level < finest; ++level)
    pipelines.set({level, level}, store.level_file(attribute, level).pipeline);
  return pipelines.to_text();
}

std::uint64_t bytes_of_levels(const Store& store, AttributeId attribute) {
  std::uint64_t bytes = 0;
  for (int level = store.base_level() + 1; level <= store.attributes()[attribute].finest_level;
       ++level)
    bytes += store.level_file(attribute, level).geometry.total_bytes();
  return bytes;
}

PLAIT_END_NAMESPACE
