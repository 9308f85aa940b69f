// plait/extend/thread_count.h: what an option `threads` means.
#pragma once

#include <string_view>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// The number of threads for an option `threads`: 0 stands for the processors that this process may
/// use. `work` begins the message. Errors: kInvalidArgument unless threads is 0 to 1024.
int thread_count(int threads, std::string_view work);

PLAIT_END_NAMESPACE
