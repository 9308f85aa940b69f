// generate/portable_math.h: transcendental functions that use only IEEE additions, multiplications
// and divisions, so that a seed gives the same mesh on every machine. The functions of the C
// library differ in the last bit between versions and processors.
#pragma once

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace generation {

constexpr double kPi = 3.14159265358979323846;

/// e^x within a few units in the last place for |x| <= 700; 0 below. REQUIRES: x <= 700.
double portable_exp(double x) noexcept;

/// Sine and cosine of an angle in turns: sin(2 pi turns) within 1e-15. REQUIRES: |turns| is below
/// 2^31.
struct SineCosine {
  double sine, cosine;
};
SineCosine portable_sine_cosine(double turns) noexcept;

}  // namespace generation
PLAIT_END_NAMESPACE
