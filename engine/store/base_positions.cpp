#include "store/base_positions.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include "base/default_arithmetic.h"
#include "plait/error.h"
#include "plait/store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

template <class Real>
void fill_base(Store& store) {
  const AttributeId position = store.add_attribute(schema_of<Vector3<Real>>("position"));
  const std::span<Vector3<Real>> records = store.base_records<Vector3<Real>>(position);
  for (std::size_t vertex = 0; vertex < records.size(); ++vertex) {
    const Vector3<double>& from = store.base().positions()[vertex];
    records[vertex] = {static_cast<Real>(from.x), static_cast<Real>(from.y),
                       static_cast<Real>(from.z)};
  }
}

}  // namespace

void check_positions(const BaseMesh& mesh, ComponentType precision) {
  if (precision != ComponentType::kFloat32 && precision != ComponentType::kFloat64)
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("positions of type {}: expected float32 or float64", to_string(precision)));
  if (precision != ComponentType::kFloat32) return;
  for (std::size_t vertex = 0; vertex < mesh.positions().size(); ++vertex)
    for (const double number :
         {mesh.positions()[vertex].x, mesh.positions()[vertex].y, mesh.positions()[vertex].z})
      if (!std::isfinite(static_cast<float>(number)))
        throw Error(ErrorCode::kInvalidArgument,
                    fmt::format("positions of type float32: vertex {} has {:g}, expected at most "
                                "{:g}: take float64",
                                vertex, number, std::numeric_limits<float>::max()));
}

void add_base_positions(Store& store, ComponentType precision) {
  const DefaultArithmetic arithmetic;
  check_positions(store.base(), precision);
  precision == ComponentType::kFloat64 ? fill_base<double>(store) : fill_base<float>(store);
}

PLAIT_END_NAMESPACE
