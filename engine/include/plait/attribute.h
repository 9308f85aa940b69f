// plait/attribute.h: a named per-vertex quantity: a fixed-size record of equal components.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "plait/namespace.h"
#include "plait/vector3.h"

PLAIT_BEGIN_NAMESPACE

/// Stored: never renumber.
enum class ComponentType : std::uint8_t {
  kFloat32 = 1,
  kFloat64 = 2,
  kInt8 = 3,
  kInt16 = 4,
  kInt32 = 5,
  kInt64 = 6,
  kUint8 = 7,
  kUint16 = 8,
  kUint32 = 9,
  kUint64 = 10,
};

/// Bytes of one component; 0 for a value that is none of the enumerators.
std::size_t component_bytes(ComponentType type) noexcept;
std::string_view to_string(ComponentType type) noexcept;

/// The name of an attribute, and the type of its records.
struct AttributeSchema {
  std::string name = {};  ///< 1 to 31 characters of [A-Za-z0-9_-]
  ComponentType type = ComponentType::kFloat32;
  std::uint32_t components = 3;  ///< 1 to 255

  std::size_t record_bytes() const { return component_bytes(type) * components; }
  friend bool operator==(const AttributeSchema&, const AttributeSchema&) = default;
};

/// The schema of a C++ record type. A program specialises it for record types of its own.
template <class Record>
struct RecordTraits;
template <>
struct RecordTraits<float> {
  static constexpr ComponentType kType = ComponentType::kFloat32;
  static constexpr std::uint32_t kComponents = 1;
};
template <>
struct RecordTraits<double> {
  static constexpr ComponentType kType = ComponentType::kFloat64;
  static constexpr std::uint32_t kComponents = 1;
};
template <>
struct RecordTraits<std::uint32_t> {
  static constexpr ComponentType kType = ComponentType::kUint32;
  static constexpr std::uint32_t kComponents = 1;
};
template <class Real>
struct RecordTraits<Vector3<Real>> {
  static constexpr ComponentType kType = RecordTraits<Real>::kType;
  static constexpr std::uint32_t kComponents = 3;
};

/// The schema of an attribute called `name` that holds `Record`s.
template <class Record>
AttributeSchema schema_of(std::string name) {
  static_assert(sizeof(Record) % RecordTraits<Record>::kComponents == 0);
  return {std::move(name), RecordTraits<Record>::kType, RecordTraits<Record>::kComponents};
}

PLAIT_END_NAMESPACE
