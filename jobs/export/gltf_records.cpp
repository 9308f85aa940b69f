#include "export/gltf_records.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr double kMostByte = 255, kMostWord = 65535;
constexpr double kUnitTolerance = 1e-5;

template <class Number>
Number load(std::span<const std::byte> record, std::size_t at) noexcept {
  Number number;
  std::memcpy(&number, record.data() + at * sizeof(Number), sizeof(Number));
  return number;
}

template <class Number>
void store(std::span<std::byte> numbers, std::size_t at, Number number) noexcept {
  std::memcpy(numbers.data() + at * sizeof(Number), &number, sizeof(Number));
}

/// Source: IEC 61966-2-1, "Default RGB colour space - sRGB", 1999, section 5.2.
double linear_of(double srgb) noexcept {
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

void convert_color(std::span<const std::byte> record, ComponentType type, const GltfColumn& column,
                   std::span<std::byte> numbers) noexcept {
  for (std::uint32_t at = 0; at < column.components; ++at) {
    double number = std::clamp(number_of(record, type, at), 0.0, 1.0);
    if (column.srgb && at < 3) number = linear_of(number);  // the fourth one is alpha
    if (column.normalized)
      store(numbers, at, static_cast<std::uint16_t>(std::round(number * kMostWord)));
    else
      store(numbers, at, static_cast<float>(number));
  }
}

GltfVector convert_position(const GltfVector& point, const GltfPlacement& placement,
                            std::span<std::byte> numbers, double& error) noexcept {
  GltfVector record{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (placement.lattice) {
      record[axis] =
          std::round(point[axis] / placement.step) - placement.translation[axis] / placement.step;
      store(numbers, axis, static_cast<std::uint16_t>(record[axis]));
    } else {
      const auto narrow = static_cast<float>(point[axis] - placement.translation[axis]);
      record[axis] = narrow;
      store(numbers, axis, narrow);
    }
    error = std::max(error, std::fabs(placement.translation[axis] + placement.step * record[axis] -
                                      point[axis]));
  }
  return record;
}

}  // namespace

GltfBounds no_bounds() noexcept {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  return {{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
}

void extend(GltfBounds& bounds, const GltfVector& point) noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    bounds.low[axis] = std::min(bounds.low[axis], point[axis]);
    bounds.high[axis] = std::max(bounds.high[axis], point[axis]);
  }
}

GltfVector vector_of(std::span<const std::byte> record, ComponentType type, bool z_up) noexcept {
  const GltfVector vector = {number_of(record, type, 0), number_of(record, type, 1),
                             number_of(record, type, 2)};
  return z_up ? GltfVector{vector[0], vector[2], -vector[1]} : vector;
}

std::optional<GltfVector> direction_of(const GltfVector& vector) noexcept {
  const double longest =
      std::max({std::fabs(vector[0]), std::fabs(vector[1]), std::fabs(vector[2])});
  const double sum = vector[0] + vector[1] + vector[2];  // not a number if one of them is not
  if (!(longest > 0) || !std::isfinite(longest) || std::isnan(sum)) return std::nullopt;
  GltfVector scaled = {vector[0] / longest, vector[1] / longest, vector[2] / longest};
  const double length =
      std::sqrt(scaled[0] * scaled[0] + scaled[1] * scaled[1] + scaled[2] * scaled[2]);
  for (double& number : scaled) number /= length;
  return scaled;
}

bool is_unit(const GltfVector& vector) noexcept {
  const double square = vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2];
  return std::fabs(std::sqrt(square) - 1) <= kUnitTolerance;
}

double number_of(std::span<const std::byte> record, ComponentType type,
                 std::uint32_t component) noexcept {
  switch (type) {
    case ComponentType::kFloat64:
      return load<double>(record, component);
    case ComponentType::kUint8:
      return load<std::uint8_t>(record, component) / kMostByte;
    case ComponentType::kUint16:
      return load<std::uint16_t>(record, component) / kMostWord;
    default:
      return load<float>(record, component);
  }
}

GltfVector convert_record(std::span<const std::byte> record, ComponentType type,
                          const GltfColumn& column, const GltfPlacement& placement,
                          std::span<std::byte> numbers, double& error) noexcept {
  switch (column.conversion) {
    case GltfConversion::kCopy:
      std::memcpy(numbers.data(), record.data(), record.size());
      break;
    case GltfConversion::kPosition:
    case GltfConversion::kLattice:
      return convert_position(vector_of(record, type, placement.z_up), placement, numbers, error);
    case GltfConversion::kUnit:
    case GltfConversion::kUnitBytes: {
      GltfVector normal = vector_of(record, type, placement.z_up);
      if (!is_unit(normal)) normal = direction_of(normal).value_or(normal);
      for (std::size_t axis = 0; axis < 3; ++axis)
        if (column.conversion == GltfConversion::kUnit)
          store(numbers, axis, static_cast<float>(normal[axis]));
        else
          store(numbers, axis, static_cast<std::int8_t>(std::round(normal[axis] * 127)));
      break;
    }
    case GltfConversion::kColor:
      convert_color(record, type, column, numbers);
      break;
    case GltfConversion::kTexture:
      store(numbers, 0, static_cast<float>(number_of(record, type, 0)));
      store(numbers, 1, 1 - static_cast<float>(number_of(record, type, 1)));
      break;
    case GltfConversion::kNarrow:
      for (std::uint32_t at = 0; at < column.components; ++at)
        store(numbers, at, static_cast<float>(number_of(record, type, at)));
      break;
  }
  return {};
}

PLAIT_END_NAMESPACE
