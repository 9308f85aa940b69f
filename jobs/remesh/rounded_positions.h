// remesh/rounded_positions.h: remesh --max-error.
#pragma once

#include "plait/attribute.h"
#include "plait/detail/namespace.h"
#include "plait/extend/rounding.h"
#include "remesh/sampled_surface.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Rounds the positions of a surface within the bound: those of all levels as plait convert does,
/// so that converting the store with the same bound changes nothing; and those of the base mesh,
/// which convert keeps, to multiples of the largest power of two that the bound allows, because
/// base.mesh stores such numbers in few bytes. The base mesh itself is left to the caller. Returns
/// what the version of the store records. Errors: those of Rounder.
Rounding round_positions(SampledSurface& surface, ComponentType precision, const ErrorBound& bound);

PLAIT_END_NAMESPACE
