// Gradient noise in space (K. Perlin, "Improving Noise", SIGGRAPH 2002). Every point of the integer
// lattice has a direction, chosen by a hash. The noise is 0 on the lattice, rises along these
// directions, and is blended between the eight corners of a cell. So it has hardly any waves longer
// than two lattice steps, and hardly any shorter than half a step.
#pragma once

#include <cstdint>

#include "plait/detail/namespace.h"
#include "plait/extend/vector3.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// From -1 to 1. The same bits on every machine: it uses no function that a library of mathematics
/// may round in its own way. REQUIRES: coordinates whose whole part an int64 holds.
double gradient_noise(const Vector3<double>& at, std::uint64_t key) noexcept;

PLAIT_END_NAMESPACE
