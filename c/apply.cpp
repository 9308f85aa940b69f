// A pass over one level in place, block by block.
#include <fmt/format.h>

#include "guard.h"
#include "handles.h"
#include "plait.h"
#include "plait/detail/level_file.h"
#include "plait/extend/session.h"
#include "plait/extend/store_access.h"

namespace plait::c {
namespace {

void apply(Store& store, AttributeId attribute, int level, Access access, plait_edit edit,
           void* user) {
  const std::size_t record_bytes = store.attributes()[attribute].schema.record_bytes();
  LevelFile& file = StoreAccess::level_file(store, attribute, level);
  if (access == Access::kUpdate) StoreAccess::check_readable(store, attribute, level);
  const StorePass under_way(store, "apply to");
  Session session = StoreAccess::open_session(store);
  UnfinishedLevels unfinished;
  unfinished.add(file, access);
  for (std::uint64_t block = 0; block < file.geometry.block_count(); ++block) {
    PinnedBlock pinned = session.pin(file, block, access);
    if (access == Access::kUpdate && block + 1 < file.geometry.block_count())
      session.prefetch(file, block + 1);
    const std::span<std::byte> bytes =
        pinned.bytes().first(static_cast<std::size_t>(file.geometry.block_bytes(block)));
    if (edit(bytes.data(), file.geometry.block_offset(block) / record_bytes,
             bytes.size() / record_bytes, user) == 0) {
      pinned.abandon();
      refuse_cancelled("apply");
    }
  }
  unfinished.finish();
}

}  // namespace

void check_level(const Store& store, AttributeId attribute, std::int32_t level) {
  const AttributeInfo& info = store.attributes()[attribute];
  if (level < store.base_level() || level > info.finest_level)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("level of '{}': expected {} to {}, found {}", info.schema.name,
                            store.base_level(), info.finest_level, level));
}

}  // namespace plait::c

using namespace plait::c;

plait_status plait_store_apply(plait_store* store, const char* name, int32_t level, int32_t access,
                               plait_edit edit, void* user) {
  return guarded("plait_store_apply", [&] {
    plait::Store& changed = changed_store(store);
    const plait::AttributeId attribute = attribute_named(changed, name);
    check_level(changed, attribute, level);
    check_choice("access", access, 2);
    check_given(edit, "edit");
    if (!store->writable)
      throw plait::Error(plait::ErrorCode::kBadState,
                         fmt::format("apply to {}: the store was opened for reading; open it with "
                                     "writable = 1",
                                     changed.path().native()));
    if (level > changed.base_level())
      return apply(
          changed, attribute, level,
          access == PLAIT_ACCESS_UPDATE ? plait::Access::kUpdate : plait::Access::kOverwrite, edit,
          user);
    const std::span<std::byte> bytes = changed.base_bytes(attribute);
    const plait::StorePass under_way(changed, "apply to");
    if (edit(bytes.data(), 0, changed.base().vertex_count(), user) == 0) refuse_cancelled("apply");
  });
}
