// plait/kernels/recompute_subdivision.h: what plait::repair needs to repair a subdivision.
//
//   plait::repair(path, {}, backends, plait::recompute_subdivision());
#pragma once

#include <vector>

#include "plait/kernels/one_ring.h"
#include "plait/namespace.h"
#include "plait/repair.h"

PLAIT_BEGIN_NAMESPACE

/// Computes attribute "position" again, and "normal" if it has the same finest level, by the scheme
/// that the store's provenance names: a scheme of the library, or one of `own_schemes`
/// (plait/kernels/own_rule.h). A store records only the name of a program's own rule. If the rule
/// of this name has other formulas now, then the checksums differ and repair() writes nothing. The
/// result has a copy of `own_schemes`; several threads may call it at once.
PlanRecomputation recompute_subdivision(std::vector<OneRingScheme> own_schemes = {});

PLAIT_END_NAMESPACE
