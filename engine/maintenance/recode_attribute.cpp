#include "plait/extend/recode_attribute.h"

#include <fmt/format.h>

#include <utility>

#include "maintenance/compare_attribute.h"
#include "plait/error.h"
#include "plait/extend/copy_levels.h"
#include "plait/extend/store_access.h"
#include "store/attribute_levels.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// A name that no attribute of the store has.
std::string free_name(const Store& store) {
  for (int number = 0;; ++number)
    if (std::string name = fmt::format("recoded-{}", number); !store.has_attribute(name))
      return name;
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
  AttributeSchema schema = store.attributes()[attribute].schema;
  schema.name = free_name(store);
  const AttributeId copy = store.add_attribute(std::move(schema));
  try {
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
    store.replace_attribute(attribute, copy);
  } catch (...) {
    store.remove_attribute(copy);
    throw;
  }
} catch (const std::bad_alloc&) {
  throw out_of_memory("encode an attribute anew");
}

PLAIT_END_NAMESPACE
