// plait/attribute.h: a named per-vertex quantity: a fixed-size record of equal components.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "plait/detail/namespace.h"
#include "plait/extend/vector3.h"

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
constexpr std::size_t component_bytes(ComponentType type) noexcept {
  switch (type) {
    case ComponentType::kInt8:
    case ComponentType::kUint8:
      return 1;
    case ComponentType::kInt16:
    case ComponentType::kUint16:
      return 2;
    case ComponentType::kFloat32:
    case ComponentType::kInt32:
    case ComponentType::kUint32:
      return 4;
    case ComponentType::kFloat64:
    case ComponentType::kInt64:
    case ComponentType::kUint64:
      return 8;
  }
  return 0;
}
std::string_view to_string(ComponentType type) noexcept;

/// The name of an attribute, and the type of its records.
struct AttributeSchema {
  std::string name = {};  ///< 1 to 255 characters of [A-Za-z0-9_-]
  ComponentType type = ComponentType::kFloat32;
  std::uint32_t components = 3;  ///< 1 to 255

  std::size_t record_bytes() const { return component_bytes(type) * components; }
  friend bool operator==(const AttributeSchema&, const AttributeSchema&) = default;
};

/// The schema of a C++ record type. The types of components, std::array of one of them and Vector3
/// have one. A program specialises it for a record type of its own: a trivially copyable struct of
/// components of one type, without padding.
///
///   struct Material { float density, stiffness; };
///   template <> struct plait::RecordTraits<Material> : plait::RecordOf<float, 2> {};
///
/// Pinned by tests/engine/store/own_attributes_test.cpp.
template <class Record>
struct RecordTraits {
  // The condition depends on the type, so a program that specialises the template never meets it.
  static_assert(
      sizeof(Record) == 0,
      "a record type of your own needs RecordTraits, before it is used: template <> struct "
      "plait::RecordTraits<MyRecord> : plait::RecordOf<float, 3> {};");
  static constexpr ComponentType kType = ComponentType::kUint8;  // no second message
  static constexpr std::uint32_t kComponents = sizeof(Record);
};

/// The traits of records that are one component.
template <ComponentType type>
struct ComponentTraits {
  static constexpr ComponentType kType = type;
  static constexpr std::uint32_t kComponents = 1;
};
template <>
struct RecordTraits<float> : ComponentTraits<ComponentType::kFloat32> {};
template <>
struct RecordTraits<double> : ComponentTraits<ComponentType::kFloat64> {};
template <>
struct RecordTraits<std::int8_t> : ComponentTraits<ComponentType::kInt8> {};
template <>
struct RecordTraits<std::int16_t> : ComponentTraits<ComponentType::kInt16> {};
template <>
struct RecordTraits<std::int32_t> : ComponentTraits<ComponentType::kInt32> {};
template <>
struct RecordTraits<std::int64_t> : ComponentTraits<ComponentType::kInt64> {};
template <>
struct RecordTraits<std::uint8_t> : ComponentTraits<ComponentType::kUint8> {};
template <>
struct RecordTraits<std::uint16_t> : ComponentTraits<ComponentType::kUint16> {};
template <>
struct RecordTraits<std::uint32_t> : ComponentTraits<ComponentType::kUint32> {};
template <>
struct RecordTraits<std::uint64_t> : ComponentTraits<ComponentType::kUint64> {};

/// `components` numbers of the type `Component`.
template <class Component, std::uint32_t components>
struct RecordOf {
  static_assert(components >= 1 && components <= 255, "a record has 1 to 255 components");
  static constexpr ComponentType kType = RecordTraits<Component>::kType;
  static constexpr std::uint32_t kComponents = components;
};
template <class Real>
struct RecordTraits<Vector3<Real>> : RecordOf<Real, 3> {};
template <class Component, std::size_t components>
struct RecordTraits<std::array<Component, components>>
    : RecordOf<Component, static_cast<std::uint32_t>(components)> {};

/// Refuses, when the program is compiled, a record type that does not fit its RecordTraits.
template <class Record>
constexpr void check_record_type() {
  static_assert(std::is_trivially_copyable_v<Record>,
                "the records of an attribute are copied as bytes: the type of a record must be "
                "trivially copyable");
  static_assert(sizeof(Record) == RecordTraits<Record>::kComponents *
                                      component_bytes(RecordTraits<Record>::kType),
                "the size of a record is not that of its components in RecordTraits");
  static_assert(alignof(Record) <= alignof(std::max_align_t),
                "records of an attribute are not aligned more strictly than any scalar type");
}

/// The schema of an attribute called `name` that holds `Record`s.
template <class Record>
AttributeSchema schema_of(std::string name) {
  check_record_type<Record>();
  return {std::move(name), RecordTraits<Record>::kType, RecordTraits<Record>::kComponents};
}

PLAIT_END_NAMESPACE
