#include <fmt/format.h>

#include "plait/error.h"
#include "plait/kernels/subdivide.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

std::string_view to_string(ExecutorKind executor) noexcept {
  switch (executor) {
    case ExecutorKind::kFused:
      return "fused";
    case ExecutorKind::kSweep:
      return "sweep";
    case ExecutorKind::kTransparent:
      return "transparent";
  }
  return "unknown";
}

ExecutorKind executor_from_name(std::string_view name) {
  for (const ExecutorKind executor :
       {ExecutorKind::kFused, ExecutorKind::kSweep, ExecutorKind::kTransparent})
    if (name == to_string(executor)) return executor;
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("executor '{}': expected fused, sweep or transparent", name));
}

PLAIT_END_NAMESPACE
