// tools/stand_ins.h: warns where another backend stands in for one that this machine cannot use.
#pragma once

#include <functional>
#include <string>

#include "plait/extend/backend_registry.h"

namespace plait {

/// A copy of `backends` that calls `warn` for what a store cannot have on this machine when it is
/// opened (plait/extend/notices.h), once for each line. For one thread. Pinned by
/// tests/tools/store_commands_test.cpp.
BackendRegistry with_warnings(const BackendRegistry& backends,
                              const std::function<void(const std::string&)>& warn);

}  // namespace plait
