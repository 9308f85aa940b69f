// A rule of a program's own, for tests.
#pragma once

namespace plait::test {

/// Loop's rule with a tension `w` and a smoothing `s`, of which Loop's have 1/8 and 0.6 at a vertex
/// of valence 6.
struct OwnTensionRule {
  double w = 0.08, s = 0.55;

  template <class V>
  V odd(V a, V b, V c, V d) const {
    return (0.5 - w) * (a + b) + w * (c + d);
  }
  template <class V>
  V odd_border(V a, V b) const {
    return 0.5 * (a + b);
  }
  template <class V>
  V even(V v, V ring) const {
    return (1 - s) * v + s / 6 * ring;
  }
  template <class V>
  V even_border(V v, V p, V q) const {
    return 0.5 * v + 0.25 * (p + q);
  }
  double even_weight(int valence) const { return s / valence; }
};

}  // namespace plait::test
