#include "passes/gradient_noise.h"

#include <cmath>

#include "passes/vertex_noise.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The offset from a lattice point times its direction, times sqrt(2). The directions are those to
/// the middles of a cube's twelve edges; four of them occur twice, so that four bits choose one.
double rise(std::uint64_t word, double x, double y, double z) noexcept {
  const auto choice = static_cast<unsigned>(word >> 60);
  const double u = choice < 8 ? x : y;
  const double v = choice < 4 ? y : choice == 12 || choice == 14 ? x : z;
  return ((choice & 1) == 0 ? u : -u) + ((choice & 2) == 0 ? v : -v);
}

/// From 0 to 1, with a first and a second derivative of 0 at both ends.
double blend(double t) noexcept { return t * t * t * (t * (t * 6 - 15) + 10); }

double between(double t, double a, double b) noexcept { return a + t * (b - a); }

std::uint64_t hash(std::uint64_t key, std::int64_t x, std::int64_t y, std::int64_t z) noexcept {
  return random_word(key ^ static_cast<std::uint64_t>(x) * 0xd1342543de82ef95u ^
                         static_cast<std::uint64_t>(y) * 0xaf251af3b0f025b5u,
                     static_cast<std::uint64_t>(z));
}

}  // namespace

double gradient_noise(const Vector3<double>& at, std::uint64_t key) noexcept {
  const Vector3<double> cell{std::floor(at.x), std::floor(at.y), std::floor(at.z)};
  const Vector3<double> t = at - cell;
  const auto i = static_cast<std::int64_t>(cell.x), j = static_cast<std::int64_t>(cell.y),
             k = static_cast<std::int64_t>(cell.z);
  const auto corner = [&](int x, int y, int z) {
    return rise(hash(key, i + x, j + y, k + z), t.x - x, t.y - y, t.z - z);
  };
  const double u = blend(t.x), v = blend(t.y), w = blend(t.z);
  const auto along_x = [&](int y, int z) { return between(u, corner(0, y, z), corner(1, y, z)); };
  const auto across = [&](int z) { return between(v, along_x(0, z), along_x(1, z)); };
  // A sum of distances with the blend's weights is at most the root of the weighted sum of their
  // squares, which is 3/4 at the middle of a cell and less elsewhere. With the sqrt(2) of rise(),
  // the factor 1 / sqrt(2) / sqrt(3/4) makes 1 the bound.
  constexpr double kToOne = 0.81649658092772603;
  return kToOne * between(w, across(0), across(1));
}

PLAIT_END_NAMESPACE
