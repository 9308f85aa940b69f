// base/number_type.h: what depends on the type of an attribute's numbers.
#pragma once

#include <cstdint>

#include "plait/attribute.h"
#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Calls work(Number()) for the type, and returns what it returns.
template <class Work>
decltype(auto) with_number_type(ComponentType type, Work&& work) {
  switch (type) {
    case ComponentType::kFloat64:
      return work(double{});
    case ComponentType::kInt8:
      return work(std::int8_t{});
    case ComponentType::kInt16:
      return work(std::int16_t{});
    case ComponentType::kInt32:
      return work(std::int32_t{});
    case ComponentType::kInt64:
      return work(std::int64_t{});
    case ComponentType::kUint8:
      return work(std::uint8_t{});
    case ComponentType::kUint16:
      return work(std::uint16_t{});
    case ComponentType::kUint32:
      return work(std::uint32_t{});
    case ComponentType::kUint64:
      return work(std::uint64_t{});
    case ComponentType::kFloat32:
      break;
  }
  return work(float{});
}

/// Whether records are points in space: float32 x 3 or float64 x 3.
inline bool holds_points(const AttributeSchema& schema) noexcept {
  return schema.components == 3 &&
         (schema.type == ComponentType::kFloat32 || schema.type == ComponentType::kFloat64);
}

PLAIT_END_NAMESPACE
