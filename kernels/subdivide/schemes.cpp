#include <fmt/format.h>

#include "plait/error.h"
#include "plait/kernels/subdivide.h"

namespace plait {

std::string_view to_string(Scheme scheme) noexcept {
  switch (scheme) {
    case Scheme::kLoop:
      return "loop";
    case Scheme::kButterfly:
      return "butterfly";
    case Scheme::kMidpoint:
      return "midpoint";
  }
  return "unknown";
}

Scheme scheme_from_name(std::string_view name) {
  for (const Scheme scheme : {Scheme::kLoop, Scheme::kButterfly, Scheme::kMidpoint})
    if (name == to_string(scheme)) return scheme;
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("scheme '{}': expected loop, butterfly or midpoint", name));
}

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

}  // namespace plait
