#include "export/gltf_survey.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "export/vertex_stream.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr double kLatticeSteps = 65535;

bool is_float(ComponentType type) {
  return type == ComponentType::kFloat32 || type == ComponentType::kFloat64;
}

void check_finite(const ExportTask& task, const AttributeSchema& schema, double number) {
  if (std::fabs(number) <= std::numeric_limits<float>::max()) return;
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("export {}: attribute '{}' has a number {}, but glTF files can have "
                          "finite float32 numbers only; .ply and .vtp files keep it",
                          task.store.path().native(), schema.name, number));
}

/// Where the middle of the bounds is, in multiples of a power of two that is not less than their
/// longest side: few bits, so that a reader with float32 numbers keeps them too.
GltfVector middle_of(const GltfBounds& bounds) {
  double longest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    longest = std::max(longest, bounds.high[axis] - bounds.low[axis]);
  GltfVector middle{};
  if (!(longest > 0)) return bounds.low;
  const double step = std::exp2(std::ceil(std::log2(longest)) - 1);
  for (std::size_t axis = 0; axis < 3; ++axis)
    middle[axis] = std::round((bounds.low[axis] / 2 + bounds.high[axis] / 2) / step) * step;
  return middle;
}

/// The finest lattice whose steps are powers of two and that has all vertices in 16 bits. Its
/// points are multiples of the step, so two files with the same step have a common lattice.
void set_lattice(const GltfBounds& bounds, GltfPlacement& placement) {
  double longest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    longest = std::max(longest, bounds.high[axis] - bounds.low[axis]);
  if (longest > 0) placement.step = std::exp2(std::ceil(std::log2(longest / (kLatticeSteps - 1))));
  for (std::size_t axis = 0; axis < 3; ++axis)
    placement.translation[axis] = std::round(bounds.low[axis] / placement.step) * placement.step;
}

}  // namespace

GltfSurvey survey(const ExportTask& task, std::span<const GltfColumn> columns,
                  GltfPlacement& placement) {
  std::vector<AttributeId> ids;
  std::vector<GltfColumn> read;
  for (const GltfColumn& column : columns)
    if (is_float(task.schema(column.attribute).type)) {
      ids.push_back(column.attribute);
      read.push_back(column);
    }
  GltfSurvey found;
  GltfBounds bounds = no_bounds();
  const auto look_at = [&](const GltfColumn& column, std::span<const std::byte> record) {
    const AttributeSchema& schema = task.schema(column.attribute);
    if (column.conversion == GltfConversion::kUnit ||
        column.conversion == GltfConversion::kUnitBytes) {
      const GltfVector normal = vector_of(record, schema.type, placement.z_up);
      if (!direction_of(normal))
        ++found.normals_without_direction;
      else if (!is_unit(normal))
        ++found.normals_scaled;
      return;
    }
    bool clamped = false;
    for (std::uint32_t at = 0; at < schema.components; ++at) {
      const double number = number_of(record, schema.type, at);
      check_finite(task, schema, number);
      clamped = clamped || number < 0 || number > 1;
    }
    if (column.conversion == GltfConversion::kColor && clamped) ++found.colors_clamped;
    if (column.attribute == task.position)
      extend(bounds, vector_of(record, schema.type, placement.z_up));
  };
  stream_vertices(task.store, ids, task.patches, [&](auto records, std::size_t count) {
    for (std::size_t each = 0; each < read.size(); ++each) {
      const std::size_t bytes = records[each].size() / count;
      for (std::size_t at = 0; at < count; ++at)
        look_at(read[each], records[each].subspan(at * bytes, bytes));
    }
    task.progress(0);
  });
  if (placement.lattice)
    set_lattice(bounds, placement);
  else if (placement.moves)
    placement.translation = middle_of(bounds);
  return found;
}

PLAIT_END_NAMESPACE
