#include "plait/recode_attribute.h"

#include <fmt/format.h>

#include <utility>

#include "plait/copy_levels.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// A name that no attribute of the store has.
std::string free_name(const Store& store) {
  for (int number = 0;; ++number)
    if (std::string name = fmt::format("recoded-{}", number); !store.has_attribute(name))
      return name;
}

}  // namespace

void recode_attribute(Store& store, AttributeId attribute, const std::string& pipeline,
                      const std::function<bool(std::uint64_t, std::uint64_t)>& proceed,
                      const std::optional<ErrorBound>& bound) {
  std::uint64_t total_bytes = 0, done_bytes = 0;
  for (int level = store.base_level() + 1; level <= store.attributes()[attribute].finest_level;
       ++level)
    total_bytes += store.level_file(attribute, level).geometry.total_bytes();
  std::optional<Rounder> rounder;
  if (bound)
    rounder.emplace(store.attributes()[attribute].schema, *bound,
                    std::as_const(store).base_bytes(attribute));
  AttributeSchema schema = store.attributes()[attribute].schema;
  schema.name = free_name(store);
  const AttributeId copy = store.add_attribute(std::move(schema));
  try {
    store.set_pipeline(copy, pipeline);
    copy_attribute(
        store, attribute, store, copy,
        [&](std::uint64_t copied) {
          done_bytes += copied;
          return !proceed || proceed(done_bytes, total_bytes);
        },
        rounder ? &*rounder : nullptr);
    if (bound && store.attributes()[attribute].schema.name == "position") {
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
