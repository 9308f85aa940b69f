// remesh/base_numbers.h: the base mesh of a remeshed scan as its store has it.
#pragma once

#include "plait/detail/namespace.h"
#include "remesh/base_samples.h"
#include "remesh/sampled_surface.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Numbers the base vertices in the order in which faces name them, and forgets the numbers of the
/// collapsed mesh, which nobody knows: base.mesh takes fewer bytes so. Everything that is at a
/// vertex of a level stays at its place on the faces. REQUIRES: the surface has no positions yet.
void number_in_face_order(BaseSamples& samples);

/// Gives the base mesh the positions that the surface has at its vertices.
void give_base_positions(SampledSurface& surface);

PLAIT_END_NAMESPACE
