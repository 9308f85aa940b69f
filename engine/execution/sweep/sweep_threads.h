// How many threads a sweep takes: its window needs blocks for each of them.
#pragma once

#include "plait/extend/sweep.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The threads that sweep() takes of `threads` (0: all processors): fewer if the budget does not
/// hold the window of more, at least one. Errors: as sweep_window_bytes().
int sweep_threads(Store& store, const SweepPass& pass, int threads);

PLAIT_END_NAMESPACE
