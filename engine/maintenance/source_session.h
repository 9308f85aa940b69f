// engine/maintenance/source_session.h: the session of a sweep that reads each block of a level
// once, beside another session that does the work.
#pragma once

#include "plait/detail/namespace.h"
#include "plait/store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// If a block of the level can be read without other blocks, the session gets a small share of the
/// budget, which is enough for reading ahead. The rest is for the session that does the work.
/// Errors: kOutOfMemory.
Session open_source_session(const Store& store, const LevelFile& level);

PLAIT_END_NAMESPACE
