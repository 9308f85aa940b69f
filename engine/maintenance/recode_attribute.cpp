#include "plait/extend/recode_attribute.h"

#include <algorithm>
#include <utility>

#include "maintenance/compare_attribute.h"
#include "plait/error.h"
#include "plait/extend/copy_levels.h"
#include "plait/extend/store_access.h"
#include "store/attribute_levels.h"
#include "store/store_checks.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Whether no block of the attribute takes a byte. Then there is nothing to encode. REQUIRES: all
/// blocks are written.
bool is_made_again(const Store& store, AttributeId attribute) {
  for (int level = store.base_level() + 1; level <= store.attributes()[attribute].finest_level;
       ++level)
    for (const BlockEntry& entry : StoreAccess::level_file(store, attribute, level).table.entries())
      if (entry.encoding != BlockEncoding::kPredicted) return false;
  return true;
}

/// The pipelines of levels that the attribute has and may get, once all are encoded.
LevelPipelines last_pipelines(const Store& store, AttributeId attribute) {
  LevelPipelines pipelines = named_pipelines(store, attribute);
  const auto& own = StoreAccess::state(store).attributes[attribute].last_pipelines;
  for (int level = store.base_level() + 1; level <= store.attributes()[attribute].finest_level;
       ++level) {
    const auto found = own.find(level);
    pipelines.set({level, level}, found != own.end()
                                      ? found->second
                                      : StoreAccess::level_file(store, attribute, level).pipeline);
  }
  return pipelines;
}

/// After this call, reading a level reads and decodes its file.
void drop_from_memory(Store& store, AttributeId attribute) {
  StoreAccess::pager(store).flush();
  // Blocks of finer levels hold those of coarser ones that they are encoded from.
  for (int level = store.attributes()[attribute].finest_level; level > store.base_level();
       --level) {
    LevelFile& file = StoreAccess::level_file(store, attribute, level);
    StoreAccess::pager(store).detach(file);
    StoreAccess::pager(store).attach(file);
  }
}

}  // namespace

void recode_attribute(Store& store, AttributeId attribute, const LevelPipelines& pipelines,
                      const RecodeOptions& options) try {
  StoreAccess::check_changeable(store, "encode levels of");
  check_not_needed(StoreAccess::state(store), attribute_of(StoreAccess::state(store), attribute));
  const std::uint64_t level_bytes = bytes_of_levels(store, attribute);
  std::uint64_t done_bytes = 0;
  const ProgressCallback progress = [&](const Progress& now) {
    return !options.progress || options.progress({now.phase, done_bytes + now.done,
                                                  level_bytes * (options.verify ? 2 : 1)});
  };
  std::optional<Rounder> rounder;
  if (options.bound)
    rounder.emplace(store.attributes()[attribute].schema, *options.bound,
                    std::as_const(store).base_bytes(attribute));
  const AttributeId copy =
      StoreAccess::add_replacement(store, store.attributes()[attribute].schema);
  // The program may hold the base records, and open levels refer to them. So the memory that has
  // them goes to the copy before it has levels, and the old levels refer to it too.
  auto& attributes = StoreAccess::state(store).attributes;
  std::swap(attributes[copy].base_bytes, attributes[attribute].base_bytes);
  try {
    attributes[attribute].base_bytes = attributes[copy].base_bytes;
    store.set_pipeline(copy, pipelines);
    copy_attribute(store, attribute, store, copy, progress, rounder ? &*rounder : nullptr);
    if (options.verify) {
      drop_from_memory(store, copy);
      done_bytes = level_bytes;
      compare_attribute(store, attribute, store, copy, options.bound, progress);
    }
    if (options.bound && store.attributes()[attribute].schema.name == "position") {
      Provenance provenance = store.provenance();
      provenance.scheme.clear();  // it would make other records
      StoreAccess::set_provenance(store, provenance);
    }
    StoreAccess::name_replacement(store, copy);
  } catch (...) {
    std::swap(attributes[copy].base_bytes, attributes[attribute].base_bytes);
    store.remove_attribute(copy);
    throw;
  }
} catch (const std::bad_alloc&) {
  throw out_of_memory("encode an attribute anew");
}

void Store::finish_encoding(const ProgressCallback& progress) {
  auto& attributes = state().attributes;
  const auto is_encoded = [](const Implementation::Attribute& attribute) {
    return attribute.last_pipelines.empty();
  };
  if (std::ranges::all_of(attributes, is_encoded)) return;
  check_change(state(), Change::kRemove, "encode levels of");
  state().pager->flush();
  std::uint64_t total_bytes = 0, done_bytes = 0;
  for (AttributeId id = 0; id < attributes.size(); ++id) {
    if (is_made_again(*this, id)) attributes[id].last_pipelines.clear();
    if (!is_encoded(attributes[id])) total_bytes += bytes_of_levels(*this, id);
  }
  RecodeOptions options;
  if (progress)
    options.progress = [&](const Progress& now) {
      return progress({"encode", done_bytes + now.done, total_bytes});
    };
  for (AttributeId id = 0; id < attributes.size(); ++id) {
    if (is_encoded(attributes[id])) continue;
    const std::uint64_t bytes = bytes_of_levels(*this, id);
    recode_attribute(*this, id, last_pipelines(*this, id), options);
    done_bytes += bytes;
  }
}

PLAIT_END_NAMESPACE
