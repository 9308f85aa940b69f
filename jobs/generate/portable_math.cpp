#include "generate/portable_math.h"

#include <cmath>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace generation {

double portable_exp(double x) noexcept {
  if (x < -700) return 0;
  constexpr double kLog2 = 0.693147180559945309417;
  const double power = std::floor(x / kLog2 + 0.5);
  const double rest = x - power * kLog2;  // at most log(2)/2, so 14 terms of the series are enough
  double sum = 1;
  for (int term = 14; term >= 1; --term) sum = 1 + sum * rest / term;
  return std::ldexp(sum, static_cast<int>(power));
}

SineCosine portable_sine_cosine(double turns) noexcept {
  const double quarters = std::floor(4 * turns + 0.5);
  const double angle = 2 * kPi * (turns - quarters / 4);  // at most pi/4
  const double square = angle * angle;
  double sine = 1, cosine = 1;
  for (int term = 16; term >= 2; term -= 2) {
    sine = 1 - sine * square / (term * (term + 1));
    cosine = 1 - cosine * square / (term * (term - 1));
  }
  sine *= angle;
  switch (static_cast<long>(quarters) & 3) {
    case 0:
      return {sine, cosine};
    case 1:
      return {cosine, -sine};
    case 2:
      return {-sine, -cosine};
    default:
      return {-cosine, sine};
  }
}

}  // namespace generation
PLAIT_END_NAMESPACE
