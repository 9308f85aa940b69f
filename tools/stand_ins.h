// tools/stand_ins.h: stores that were made by a backend which cannot be had here.
#pragma once

#include <functional>
#include <string>

#include "plait/backend.h"

namespace plait {

/// `backends` for opening stores: where "uring" is refused, by the kernel or since this was built
/// without it, "pread" stands in for it, whose files are the same byte for byte. `warn` is told
/// why, once a store is opened that way. New stores are made with `backends` itself, which refuses.
/// Pinned by tests/tools/store_commands_test.cpp.
BackendRegistry with_stand_ins(const BackendRegistry& backends,
                               const std::function<void(const std::string&)>& warn);

}  // namespace plait
