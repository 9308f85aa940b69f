#include "remesh/rounded_positions.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "plait/extend/vector3.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Of the step of the levels: the step of the base vertices is no larger. That of the levels
/// follows from the rounded base vertices, and may be a little smaller than it was before.
constexpr double kOfStep = 15.0 / 16;

double power_of_two_within(double step) {
  int exponent = 0;
  std::frexp(step * kOfStep, &exponent);
  return std::ldexp(1.0, exponent - 1);
}

template <class Real>
std::span<std::byte> bytes_of(std::vector<Vector3<Real>>& records) {
  return std::as_writable_bytes(std::span(records));
}

template <class Real>
Rounding round_all(std::vector<Point>& positions, std::size_t base_count,
                   const AttributeSchema& schema, const ErrorBound& bound) {
  std::vector<Vector3<Real>> records;
  for (const Point& p : positions)
    records.push_back({static_cast<Real>(p.x), static_cast<Real>(p.y), static_cast<Real>(p.z)});
  std::vector<Vector3<Real>> base(records.begin(),
                                  records.begin() + static_cast<std::ptrdiff_t>(base_count));
  const double unit = power_of_two_within(Rounder(schema, bound, bytes_of(base)).step());
  // Beyond 2^24 units, or 2^53, all numbers of the type are multiples.
  const auto rounded = [unit](Real x) {
    return static_cast<Real>(std::nearbyint(static_cast<double>(x) / unit) * unit) + Real{0};
  };
  for (Vector3<Real>& p : base) p = {rounded(p.x), rounded(p.y), rounded(p.z)};
  Rounder rounder(schema, bound, bytes_of(base));
  rounder.round(bytes_of(records).subspan(base_count * sizeof(Vector3<Real>)));
  std::ranges::copy(base, records.begin());
  std::ranges::transform(records, positions.begin(), [](const Vector3<Real>& p) {
    return Point{double{p.x}, double{p.y}, double{p.z}};
  });
  return rounder.result();
}

}  // namespace

Rounding round_positions(SampledSurface& surface, ComponentType precision,
                         const ErrorBound& bound) {
  const std::size_t base_count = surface.base.vertex_count();
  if (precision == ComponentType::kFloat64)
    return round_all<double>(surface.positions, base_count, schema_of<Point>("position"), bound);
  return round_all<float>(surface.positions, base_count, schema_of<Vector3<float>>("position"),
                          bound);
}

PLAIT_END_NAMESPACE
