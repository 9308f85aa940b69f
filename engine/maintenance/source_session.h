// engine/maintenance/source_session.h: the session of a sweep that reads each block of a level
// once, beside another session that does the work.
#pragma once

#include "plait/namespace.h"
#include "plait/store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// If the blocks of the level need no others to be read, the session has a small share: enough for
/// reading ahead. Another session of the same store then has the rest of the budget, for the
/// context of its blocks.
/// Errors: kOutOfMemory.
Session open_source_session(const Store& store, const LevelFile& level);

PLAIT_END_NAMESPACE
