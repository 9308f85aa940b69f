// Files of parts that get a second name in a store.
#pragma once

#include <string>

#include "plait/detail/namespace.h"
#include "plait/extend/directory.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// A second name for a file, or a copy where there can be none. Errors: kIo, kNoSpace.
void link_or_copy(const Directory& from, const std::string& name, const Directory& to);

/// The same in a store, where a join that was killed has left the name, or one that runs on another
/// machine gives it now: if it is the same file, it stays. Errors: as link_or_copy().
void give_name(const Directory& from, const std::string& name, const Directory& to);

PLAIT_END_NAMESPACE
