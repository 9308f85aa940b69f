// plait/detail/numbers.h: a vector of numbers whose arithmetic gives the same bits in every build.
//
// Rules are written for this type. The caller evaluates a rule on a single number, or on as many
// numbers as a vector register holds. Each number gets the same IEEE operations in the same order.
// GCC and Clang may contract a product and a sum into one operation with one rounding, if the
// processor has such an instruction (-march=x86-64-v3, every aarch64, unless -ffp-contract=off is
// given). Here they cannot: every product passes through an empty assembler statement. It costs no
// instruction, and it hides from the compiler that the value is a product. Pinned by tests/outside
// and by tests/kernels/numbers_test.cpp.
#pragma once

#include <cstring>
#include <type_traits>

#include "plait/detail/namespace.h"
#include "plait/extend/vector3.h"

PLAIT_BEGIN_NAMESPACE

/// The compiler's type for a vector of `kCount` numbers.
template <class Real, int kCount>
struct NumberVector {
  typedef Real Type __attribute__((vector_size(kCount * sizeof(Real))));
};
template <class Real>
struct NumberVector<Real, 1> {
  using Type = Real;
};

/// Returns the product after rounding, so that the compiler cannot contract it with a sum.
template <class Product>
[[gnu::always_inline]] inline Product rounded(Product product) {
  if constexpr (sizeof(Product) == sizeof(double) && !std::is_same_v<Product, double>) {
    // Two floats. Clang accepts no vector of this size here, but accepts its bits as one number.
    double bits;
    std::memcpy(&bits, &product, sizeof(bits));
    bits = rounded(bits);
    std::memcpy(&product, &bits, sizeof(bits));
  } else {
#if defined(__AVX512F__)
    asm("" : "+v"(product));
#elif defined(__x86_64__)
    asm("" : "+x"(product));
#elif defined(__aarch64__)
    asm("" : "+w"(product));
#else
    asm("" : "+m"(product));
#endif
  }
  return product;
}

/// b < a ? b : a, and b < a ? a : b, for each pair. This is one instruction on processors that have
/// an instruction with this definition. (Compilers find it only if the comparison appears once.)
template <class Real, class Vector>
[[gnu::always_inline]] inline Vector smaller_of(Vector a, Vector b) {
#if defined(__x86_64__)
  constexpr bool kFloat = std::is_same_v<Real, float>;
  if constexpr (sizeof(Vector) == 16 && kFloat) return __builtin_ia32_minps(b, a);
  if constexpr (sizeof(Vector) == 16 && !kFloat) return __builtin_ia32_minpd(b, a);
#endif
#if defined(__AVX__)
  if constexpr (sizeof(Vector) == 32 && kFloat) return __builtin_ia32_minps256(b, a);
  if constexpr (sizeof(Vector) == 32 && !kFloat) return __builtin_ia32_minpd256(b, a);
#endif
  return b < a ? b : a;
}
template <class Real, class Vector>
[[gnu::always_inline]] inline Vector larger_of(Vector a, Vector b) {
#if defined(__x86_64__)
  constexpr bool kFloat = std::is_same_v<Real, float>;
  if constexpr (sizeof(Vector) == 16 && kFloat) return __builtin_ia32_maxps(a, b);
  if constexpr (sizeof(Vector) == 16 && !kFloat) return __builtin_ia32_maxpd(a, b);
#endif
#if defined(__AVX__)
  if constexpr (sizeof(Vector) == 32 && kFloat) return __builtin_ia32_maxps256(a, b);
  if constexpr (sizeof(Vector) == 32 && !kFloat) return __builtin_ia32_maxpd256(a, b);
#endif
  return b < a ? a : b;
}

/// `kCount` numbers. `kCount` is a power of two, and the numbers fit into a register; `Real` is
/// float or double. A constant that is an operand is rounded to `Real` first.
template <class RealType, int kNumbers>
struct Numbers {
  static_assert(std::is_same_v<RealType, float> || std::is_same_v<RealType, double>);
  static_assert(kNumbers * sizeof(RealType) <= __BIGGEST_ALIGNMENT__, "no register holds as many");
  using Real = RealType;
  using Vector = typename NumberVector<Real, kNumbers>::Type;
  static constexpr int kCount = kNumbers;

  Vector v;

  /// Reads `kCount` numbers. `from` needs only the alignment of one number.
  [[gnu::always_inline]] static Numbers load(const Real* from) {
    Numbers result;
    std::memcpy(&result.v, from, sizeof(Vector));
    return result;
  }
  [[gnu::always_inline]] static Numbers zero() { return {Vector{}}; }
  [[gnu::always_inline]] void store(Real* to) const { std::memcpy(to, &v, sizeof(Vector)); }

  [[gnu::always_inline]] friend Numbers operator+(const Numbers& a, const Numbers& b) {
    return {a.v + b.v};
  }
  [[gnu::always_inline]] friend Numbers operator-(const Numbers& a, const Numbers& b) {
    return {a.v - b.v};
  }
  [[gnu::always_inline]] friend Numbers operator*(const Numbers& a, const Numbers& b) {
    return {rounded<Vector>(a.v * b.v)};
  }
  [[gnu::always_inline]] friend Numbers operator*(double factor, const Numbers& a) {
    return {rounded<Vector>(static_cast<Real>(factor) * a.v)};
  }
  [[gnu::always_inline]] friend Numbers operator/(const Numbers& a, double divisor) {
    return {a.v / static_cast<Real>(divisor)};
  }
  /// The smaller and the larger of two numbers. Of two equal numbers (such as 0 and -0), smaller()
  /// returns one and larger() the other.
  [[gnu::always_inline]] friend Numbers smaller(const Numbers& a, const Numbers& b) {
    return {smaller_of<Real, Vector>(a.v, b.v)};
  }
  [[gnu::always_inline]] friend Numbers larger(const Numbers& a, const Numbers& b) {
    return {larger_of<Real, Vector>(a.v, b.v)};
  }
};

template <class Real>
using Number = Numbers<Real, 1>;
/// As many numbers as fit into a register of the processor for which the source is compiled.
template <class Real>
using RegisterNumbers = Numbers<Real, static_cast<int>(__BIGGEST_ALIGNMENT__ / sizeof(Real))>;

/// Converts numbers to double, and back to `Real`.
template <class Real, int kCount>
[[gnu::always_inline]] inline Numbers<double, kCount> widened(const Numbers<Real, kCount>& a) {
  if constexpr (kCount == 1 || std::is_same_v<Real, double>)
    return {a.v};
  else
    return {__builtin_convertvector(a.v, typename Numbers<double, kCount>::Vector)};
}
template <class Real, int kCount>
[[gnu::always_inline]] inline Numbers<Real, kCount> narrowed(const Numbers<double, kCount>& a) {
  if constexpr (kCount == 1)
    return {static_cast<Real>(a.v)};
  else if constexpr (std::is_same_v<Real, double>)
    return a;
  else
    return {__builtin_convertvector(a.v, typename Numbers<Real, kCount>::Vector)};
}

/// Applies a rule for numbers to points: calls rule(numbers ...) for each of the three coordinates.
template <class Real, class Rule, class... Points>
[[gnu::always_inline]] inline Vector3<Real> by_axis(Rule rule, const Vector3<Real>& first,
                                                    const Points&... rest) {
  return {rule(Number<Real>{first.x}, Number<Real>{rest.x}...).v,
          rule(Number<Real>{first.y}, Number<Real>{rest.y}...).v,
          rule(Number<Real>{first.z}, Number<Real>{rest.z}...).v};
}

/// Converts points to double, and back to `Real`.
template <class Real>
Vector3<double> widen(const Vector3<Real>& v) {
  return {double(v.x), double(v.y), double(v.z)};
}
template <class Real>
Vector3<Real> narrow(const Vector3<double>& v) {
  return {static_cast<Real>(v.x), static_cast<Real>(v.y), static_cast<Real>(v.z)};
}

PLAIT_END_NAMESPACE
