// The attributes of a store, and their base records.
#include <fmt/format.h>

#include "guard.h"
#include "handles.h"
#include "plait.h"
#include "plait/attribute.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/recode_attribute.h"

namespace plait::c {
namespace {

static_assert(PLAIT_FLOAT32 == static_cast<int>(ComponentType::kFloat32));
static_assert(PLAIT_FLOAT64 == static_cast<int>(ComponentType::kFloat64));
static_assert(PLAIT_INT8 == static_cast<int>(ComponentType::kInt8));
static_assert(PLAIT_INT16 == static_cast<int>(ComponentType::kInt16));
static_assert(PLAIT_INT32 == static_cast<int>(ComponentType::kInt32));
static_assert(PLAIT_INT64 == static_cast<int>(ComponentType::kInt64));
static_assert(PLAIT_UINT8 == static_cast<int>(ComponentType::kUint8));
static_assert(PLAIT_UINT16 == static_cast<int>(ComponentType::kUint16));
static_assert(PLAIT_UINT32 == static_cast<int>(ComponentType::kUint32));
static_assert(PLAIT_UINT64 == static_cast<int>(ComponentType::kUint64));

/// The number of records in `bytes`.
std::uint64_t record_count(const Store& store, AttributeId attribute, std::size_t bytes) {
  return bytes / store.attributes()[attribute].schema.record_bytes();
}

}  // namespace

ComponentType component_type_of(plait_component_type number) {
  if (number < PLAIT_FLOAT32 || number > PLAIT_UINT64)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("type: expected {} to {} (PLAIT_FLOAT32 to PLAIT_UINT64), found {}",
                            PLAIT_FLOAT32, PLAIT_UINT64, number));
  return static_cast<ComponentType>(number);
}

std::vector<std::string> names_in(const char* const* attributes, std::uint64_t count) {
  std::vector<std::string> names;
  for (std::uint64_t at = 0; attributes != nullptr && at < count; ++at) {
    check_given(attributes[at], "attributes");
    names.emplace_back(attributes[at]);
  }
  return names;
}
}  // namespace plait::c

using namespace plait::c;

plait_status plait_store_add_attribute(plait_store* store, const char* name,
                                       plait_component_type type, uint32_t components,
                                       int32_t finest_level) {
  return guarded("plait_store_add_attribute", [&] {
    plait::Store& changed = changed_store(store);
    check_given(name, "name");
    if (finest_level < changed.base_level() || finest_level > plait::kMaxLevel)
      throw plait::Error(plait::ErrorCode::kInvalidArgument,
                         fmt::format("finest_level: expected {} to {}, found {}",
                                     changed.base_level(), plait::kMaxLevel, finest_level));
    const plait::AttributeId attribute =
        changed.add_attribute({name, component_type_of(type), components});
    for (int level = changed.base_level(); level < finest_level; ++level)
      changed.add_level(attribute);
  });
}

plait_status plait_store_add_level(plait_store* store, const char* name) {
  return guarded("plait_store_add_level", [&] {
    plait::Store& changed = changed_store(store);
    changed.add_level(attribute_named(changed, name));
  });
}

plait_status plait_store_set_pipeline(plait_store* store, const char* name, const char* pipeline) {
  return guarded("plait_store_set_pipeline", [&] {
    plait::Store& changed = changed_store(store);
    check_given(pipeline, "pipeline");
    changed.set_pipeline(attribute_named(changed, name), pipeline);
  });
}

plait_status plait_store_replace_attribute(plait_store* store, const char* name,
                                           const char* replacement) {
  return guarded("plait_store_replace_attribute", [&] {
    plait::Store& changed = changed_store(store);
    check_given(replacement, "replacement");
    changed.replace_attribute(attribute_named(changed, name), changed.attribute(replacement));
  });
}

plait_status plait_store_remove_attribute(plait_store* store, const char* name) {
  return guarded("plait_store_remove_attribute", [&] {
    plait::Store& changed = changed_store(store);
    changed.remove_attribute(attribute_named(changed, name));
  });
}

plait_status plait_store_recode_attribute(plait_store* store, const char* name,
                                          const char* pipeline) {
  return guarded("plait_store_recode_attribute", [&] {
    plait::Store& changed = changed_store(store);
    check_given(pipeline, "pipeline");
    plait::recode_attribute(changed, attribute_named(changed, name), pipeline);
  });
}

plait_status plait_store_get_base_records(const plait_store* store, const char* name,
                                          const void** records, uint64_t* count) {
  return guarded("plait_store_get_base_records", [&] {
    const plait::Store& of = read_store(store);
    const plait::AttributeId attribute = attribute_named(of, name);
    const std::span<const std::byte> bytes = of.base_bytes(attribute);
    if (records != nullptr) *records = bytes.data();
    if (count != nullptr) *count = record_count(of, attribute, bytes.size());
  });
}

plait_status plait_store_edit_base_records(plait_store* store, const char* name, void** records,
                                           uint64_t* count) {
  return guarded("plait_store_edit_base_records", [&] {
    plait::Store& changed = changed_store(store);
    if (!store->writable)
      throw plait::Error(plait::ErrorCode::kBadState,
                         fmt::format("change {}: the store was opened for reading; open it with "
                                     "writable = 1",
                                     changed.path().native()));
    const plait::AttributeId attribute = attribute_named(changed, name);
    const std::span<std::byte> bytes = changed.base_bytes(attribute);
    if (records != nullptr) *records = bytes.data();
    if (count != nullptr) *count = record_count(changed, attribute, bytes.size());
  });
}
