#include "store/base_positions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <vector>

#include "base/default_arithmetic.h"
#include "base/number_type.h"
#include "mesh/mesh_region.h"
#include "plait/error.h"
#include "plait/extend/store_access.h"
#include "store/store_state.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// To be read at placed_vertices().
std::span<const Vector3<double>> positions_of(const BaseMesh& mesh) {
  return mesh.region() != nullptr ? mesh.arrays().positions : mesh.positions();
}

template <class Real>
Vector3<Real> record_of(const Vector3<double>& from) {
  return {static_cast<Real>(from.x), static_cast<Real>(from.y), static_cast<Real>(from.z)};
}

/// take(first, positions): run after run of all positions, which are not kept.
template <class Take>
void each_run(const BaseMesh& mesh, const Take& take) {
  constexpr std::uint64_t kRun = std::uint64_t{1} << 15;
  const MeshPages& pages = *mesh.pages();
  for (std::uint64_t first = 0; first < mesh.vertex_count(); first += kRun) {
    const std::uint64_t after = std::min(first + kRun, mesh.vertex_count());
    pages.need_range(MeshArray::kPositions, first, after);
    take(first, mesh.arrays().positions.subspan(first, after - first));
    pages.forget(MeshArray::kPositions, first, after);
  }
}

template <class Real>
void fill_base(Store& store) {
  const AttributeId position = store.add_attribute(schema_of<Vector3<Real>>("position"));
  if (store.base().piece_bytes() != 0) {
    StoreAccess::begin_base_change(store, position, Access::kUpdate);
    std::vector<VertexId> vertices;
    std::vector<Vector3<Real>> records;
    return each_run(store.base(), [&](std::uint64_t first,
                                      std::span<const Vector3<double>> positions) {
      vertices.resize(positions.size());
      std::iota(vertices.begin(), vertices.end(), static_cast<VertexId>(first));
      records.resize(positions.size());
      std::ranges::transform(positions, records.begin(), record_of<Real>);
      StoreAccess::put_base_records(store, position, vertices, std::as_bytes(std::span(records)));
    });
  }
  const std::span<Vector3<Real>> records =
      StoreAccess::base_records<Vector3<Real>>(store, position);
  const std::span<const Vector3<double>> positions = positions_of(store.base());
  const VerticesAtHand vertices = placed_vertices(store.base());
  for (std::size_t at = 0; at < vertices.size(); ++at)
    records[vertices[at]] = record_of<Real>(positions[vertices[at]]);
}

void check_fits(VertexId vertex, const Vector3<double>& position) {
  for (const double number : {position.x, position.y, position.z})
    if (!std::isfinite(static_cast<float>(number)))
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("positions of type float32: vertex {} has {:g}, expected at most "
                              "{:g}: take float64",
                              vertex, number, std::numeric_limits<float>::max()));
}

}  // namespace

void check_positions(const BaseMesh& mesh, ComponentType precision) {
  if (precision != ComponentType::kFloat32 && precision != ComponentType::kFloat64)
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("positions of type {}: expected float32 or float64", to_string(precision)));
  if (precision != ComponentType::kFloat32) return;
  if (mesh.piece_bytes() != 0)
    return each_run(mesh, [](std::uint64_t first, std::span<const Vector3<double>> positions) {
      for (std::size_t at = 0; at < positions.size(); ++at)
        check_fits(static_cast<VertexId>(first + at), positions[at]);
    });
  const std::span<const Vector3<double>> positions = positions_of(mesh);
  const VerticesAtHand vertices = placed_vertices(mesh);
  for (std::size_t at = 0; at < vertices.size(); ++at)
    check_fits(vertices[at], positions[vertices[at]]);
}

void check_points(const AttributeSchema& schema, std::string_view what) {
  if (!holds_points(schema))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: attribute '{}' holds {} x {}, expected float32 x 3 or float64 x 3",
                            what, schema.name, to_string(schema.type), schema.components));
}

AttributeId position_of(const Store& store, std::string_view verb) {
  const AttributeId id = store.attribute("position");
  check_points(store.attributes()[id].schema,
               fmt::format("{} {}", verb, StoreAccess::state(store).name()));
  return id;
}

void add_base_positions(Store& store, ComponentType precision) {
  const DefaultArithmetic arithmetic;
  check_positions(store.base(), precision);
  precision == ComponentType::kFloat64 ? fill_base<double>(store) : fill_base<float>(store);
}

PLAIT_END_NAMESPACE
