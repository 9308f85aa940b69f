#include "store/base_positions.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include "base/default_arithmetic.h"
#include "mesh/mesh_region.h"
#include "plait/error.h"
#include "plait/extend/store_access.h"
#include "plait/store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// To be read at placed_vertices().
std::span<const Vector3<double>> positions_of(const BaseMesh& mesh) {
  return mesh.region() != nullptr ? mesh.arrays().positions : mesh.positions();
}

template <class Real>
void fill_base(Store& store) {
  const AttributeId position = store.add_attribute(schema_of<Vector3<Real>>("position"));
  const std::span<Vector3<Real>> records =
      StoreAccess::base_records<Vector3<Real>>(store, position);
  const std::span<const Vector3<double>> positions = positions_of(store.base());
  const VerticesAtHand vertices = placed_vertices(store.base());
  for (std::size_t at = 0; at < vertices.size(); ++at) {
    const VertexId vertex = vertices[at];
    const Vector3<double>& from = positions[vertex];
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
  const std::span<const Vector3<double>> positions = positions_of(mesh);
  const VerticesAtHand vertices = placed_vertices(mesh);
  for (std::size_t at = 0; at < vertices.size(); ++at) {
    const VertexId vertex = vertices[at];
    for (const double number : {positions[vertex].x, positions[vertex].y, positions[vertex].z})
      if (!std::isfinite(static_cast<float>(number)))
        throw Error(ErrorCode::kInvalidArgument,
                    fmt::format("positions of type float32: vertex {} has {:g}, expected at most "
                                "{:g}: take float64",
                                vertex, number, std::numeric_limits<float>::max()));
  }
}

void add_base_positions(Store& store, ComponentType precision) {
  const DefaultArithmetic arithmetic;
  check_positions(store.base(), precision);
  precision == ComponentType::kFloat64 ? fill_base<double>(store) : fill_base<float>(store);
}

PLAIT_END_NAMESPACE
