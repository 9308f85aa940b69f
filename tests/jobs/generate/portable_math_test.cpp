#include "generate/portable_math.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace plait::generation;

TEST_CASE("PortableExp_WholeRange_IsWithinAFewRoundings") {
  for (double x = -690; x <= 690; x += 0.37)
    CHECK(portable_exp(x) == Approx(std::exp(x)).epsilon(1e-13));
  CHECK(portable_exp(0) == 1);
  CHECK(portable_exp(-1e6) == 0);
}

TEST_CASE("PortableSineCosine_SeveralTurns_IsWithinRounding") {
  for (double turns = -5; turns <= 5; turns += 0.0137) {
    const auto [sine, cosine] = portable_sine_cosine(turns);
    CHECK(sine == Approx(std::sin(2 * kPi * turns)).margin(2e-14));
    CHECK(cosine == Approx(std::cos(2 * kPi * turns)).margin(2e-14));
  }
}
