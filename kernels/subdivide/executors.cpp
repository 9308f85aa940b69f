#include <array>
#include <cstddef>
#include <span>

#include "base/text.h"
#include "plait/extend/fused.h"
#include "plait/extend/store_access.h"
#include "plait/subdivide.h"
#include "subdivide/steps.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

namespace {

constexpr NameTable<ExecutorKind, 4> kExecutors("executor",
                                                {{ExecutorKind::kAuto, "auto"},
                                                 {ExecutorKind::kFused, "fused"},
                                                 {ExecutorKind::kSweep, "sweep"},
                                                 {ExecutorKind::kTransparent, "transparent"}});

}  // namespace

std::string_view to_string(ExecutorKind executor) noexcept { return kExecutors.name_of(executor); }

ExecutorKind executor_from_name(std::string_view name) { return kExecutors.find(name); }

ExecutorKind executor_for(const Store& store, const SubdivideOptions& wanted) {
  if (wanted.executor != ExecutorKind::kAuto) return wanted.executor;
  const SubdivideOptions options = with_threads(wanted);
  const AttributeId position = store.attribute("position");
  const int levels = options.levels - store.base_level();
  if (store.attributes()[position].finest_level != store.base_level() || options.level_done ||
      levels < 1 || levels > kMostFusedLevels)
    return ExecutorKind::kSweep;
  const std::size_t record_bytes = store.attributes()[position].schema.record_bytes();
  // Records of normals are not larger than those of positions.
  const std::array<std::size_t, 2> records = {record_bytes, record_bytes};
  return fused_frame_bytes(store, std::span(records).first(options.normals ? 2 : 1), options.levels,
                           options.threads) <= StoreAccess::pager(store).budget_bytes()
             ? ExecutorKind::kFused
             : ExecutorKind::kSweep;
}

PLAIT_END_NAMESPACE
