// How much of a random or repeated test runs under a sanitizer.
#pragma once

namespace plait::test {

/// `whole`, or `part` under the address or the thread sanitizer: it makes each step some times as
/// long, and finds no more in more steps of the same kind.
template <class Number>
constexpr Number unless_sanitized([[maybe_unused]] Number whole, [[maybe_unused]] Number part) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return part;
#else
  return whole;
#endif
}

}  // namespace plait::test
