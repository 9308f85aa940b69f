// tools/stand_ins.h: opens stores whose backend this machine cannot use.
#pragma once

#include <functional>
#include <string>

#include "plait/extend/backend_registry.h"

namespace plait {

/// A copy of `backends` for opening existing stores. If the kernel or this build refuses "uring",
/// the copy uses "pread" instead, whose files are the same byte for byte. It calls `warn` with the
/// reason when the first store is opened that way. For new stores use `backends` itself, which
/// throws.
/// Pinned by tests/tools/store_commands_test.cpp.
BackendRegistry with_stand_ins(const BackendRegistry& backends,
                               const std::function<void(const std::string&)>& warn);

}  // namespace plait
