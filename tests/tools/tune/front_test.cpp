#include "tune/front.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

namespace plait::tune {

TEST_CASE("ParetoFront_KeepsWhatNothingBeats") {
  const std::vector<Costs> choices = {{4, 1}, {1, 9}, {2, 5}, {3, 5}, {2, 6}, {5, 1}};
  CHECK(pareto_front(choices) == std::vector<std::size_t>{1, 2, 0});
  CHECK(pareto_front({}).empty());
}

TEST_CASE("ParetoFront_OfEqualChoices_KeepsTheFirst") {
  CHECK(pareto_front(std::vector<Costs>{{1, 1}, {1, 1}, {1, 2}}) == std::vector<std::size_t>{0});
}

TEST_CASE("ParetoFront_OfRandomChoices_IsTheDefinition") {
  std::mt19937 random(5);
  for (int repeat = 0; repeat < 50; ++repeat) {
    std::vector<Costs> choices(40, Costs(3));
    for (Costs& costs : choices)
      for (double& value : costs) value = static_cast<double>(random() % 6);
    std::vector<std::size_t> front = pareto_front(choices);
    std::ranges::sort(front);
    std::vector<std::size_t> expected;
    for (std::size_t i = 0; i < choices.size(); ++i) {
      bool beaten = false;
      for (std::size_t j = 0; j < choices.size(); ++j) {
        bool no_more = true, less = false;
        for (std::size_t k = 0; k < 3; ++k) {
          no_more = no_more && choices[j][k] <= choices[i][k];
          less = less || choices[j][k] < choices[i][k];
        }
        beaten = beaten || (no_more && (less || j < i));
      }
      if (!beaten) expected.push_back(i);
    }
    CHECK(front == expected);
  }
}

TEST_CASE("BreakEven_OfOverlappingWork_IsTheClosedForm") {
  // 1 GB and 10 s of the processor, against 4 GB and 1 s: max(1e9 / D, 10) = max(4e9 / D, 1).
  const auto small = [](double speed) { return std::max(1e9 / speed, 10.0); };
  const auto fast = [](double speed) { return std::max(4e9 / speed, 1.0); };
  CHECK(break_even(small, fast).value() == Approx(4e8).epsilon(1e-3));
}

TEST_CASE("BreakEven_OfWorkThatDoesNotOverlap_IsTheClosedForm") {
  // 1e9 / D + 10 = 4e9 / D + 1.
  const auto small = [](double speed) { return 1e9 / speed + 10.0; };
  const auto fast = [](double speed) { return 4e9 / speed + 1.0; };
  CHECK(break_even(small, fast).value() == Approx(3e9 / 9).epsilon(1e-3));
}

TEST_CASE("BreakEven_IfOneIsAlwaysBetter_IsNothing") {
  const auto less = [](double speed) { return 1e9 / speed; };
  const auto more = [](double speed) { return 2e9 / speed + 1; };
  CHECK(!break_even(less, more));
  CHECK(!break_even(more, less));
  CHECK(!break_even(less, less));
}

}  // namespace plait::tune
