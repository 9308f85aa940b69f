// Files of parts in a joined store.
#pragma once

#include <string>

#include "plait/detail/namespace.h"
#include "plait/extend/directory.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// A second name for a file, or a copy where there can be none. Errors: kIo, kNoSpace.
void link_or_copy(const Directory& from, const std::string& name, const Directory& to);

PLAIT_END_NAMESPACE
