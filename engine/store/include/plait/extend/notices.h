// plait/extend/notices.h: what a machine does not give a store.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

class Store;

/// What this machine does not give the store, one line each, so far: a backend that the kernel
/// refuses, so that another one reads its files; transfers past the page cache, or locks, that the
/// file system does not have. Threads: const shared (docs/threads.md).
std::vector<std::string> notices(const Store& store);

/// Passes each of them to `warn`, if there is one. `named`, if it is not empty, stands for the path
/// of the store in them: that of an output that has its final name later.
void tell_notices(const Store& store, const std::function<void(const std::string&)>& warn,
                  const std::filesystem::path& named = {});

PLAIT_END_NAMESPACE
