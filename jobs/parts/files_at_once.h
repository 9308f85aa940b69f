// Works on many small files at once. On a disk of another machine nearly all of the time of a small
// file is waiting for answers, one system call after another.
#pragma once

#include <cstddef>
#include <functional>
#include <string_view>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Calls body(i) for all i below `count`, by the calling thread and up to 31 others, or fewer if
/// the system allows no more. The calling thread calls tell(number of calls begun) before each of
/// its own and once more, unless it is empty; it may throw. `name` is for messages. Throws the
/// first error, when all calls that were begun have ended.
void each_file_at_once(std::size_t count, std::string_view name,
                       const std::function<void(std::size_t)>& body,
                       const std::function<void(std::size_t)>& tell);

PLAIT_END_NAMESPACE
