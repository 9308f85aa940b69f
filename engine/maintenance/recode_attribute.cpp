#include "plait/recode_attribute.h"

#include <fmt/format.h>

#include <utility>

#include "plait/attribute_levels.h"
#include "plait/compare_attribute.h"
#include "plait/copy_levels.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// A name that no attribute of the store has.
std::string free_name(const Store& store) {
  for (int number = 0;; ++number)
    if (std::string name = fmt::format("recoded-{}", number); !store.has_attribute(name))
      return name;
}

/// Reading the levels then decodes what their files have.
void drop_from_memory(Store& store, AttributeId attribute) {
  store.pager().flush();
  for (int level = store.base_level() + 1; level <= store.attributes()[attribute].finest_level;
       ++level) {
    LevelFile& file = store.level_file(attribute, level);
    store.pager().detach(file);
    store.pager().attach(file);
  }
}

}  // namespace

void recode_attribute(Store& store, AttributeId attribute, const std::string& pipelines,
                      const RecodeOptions& options) {
  const std::uint64_t total_bytes = bytes_of_levels(store, attribute) * (options.verify ? 2 : 1);
  std::uint64_t done_bytes = 0;
  const auto proceed = [&](std::uint64_t bytes) {
    done_bytes += bytes;
    return !options.proceed || options.proceed(done_bytes, total_bytes);
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
    copy_attribute(store, attribute, store, copy, proceed, rounder ? &*rounder : nullptr);
    if (options.verify) {
      drop_from_memory(store, copy);
      compare_attribute(store, attribute, store, copy, options.bound, proceed);
    }
    if (options.bound && store.attributes()[attribute].schema.name == "position") {
      Provenance provenance = store.provenance();
      provenance.scheme.clear();  // it would make other records
      store.set_provenance(provenance);
    }
    store.replace_attribute(attribute, copy);
  } catch (...) {
    store.remove_attribute(copy);
    throw;
  }
}

PLAIT_END_NAMESPACE
