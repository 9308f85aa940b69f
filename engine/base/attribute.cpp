#include "plait/attribute.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

std::string_view to_string(ComponentType type) noexcept {
  switch (type) {
    case ComponentType::kFloat32:
      return "float32";
    case ComponentType::kFloat64:
      return "float64";
    case ComponentType::kInt8:
      return "int8";
    case ComponentType::kInt16:
      return "int16";
    case ComponentType::kInt32:
      return "int32";
    case ComponentType::kInt64:
      return "int64";
    case ComponentType::kUint8:
      return "uint8";
    case ComponentType::kUint16:
      return "uint16";
    case ComponentType::kUint32:
      return "uint32";
    case ComponentType::kUint64:
      return "uint64";
  }
  return "unknown";
}

PLAIT_END_NAMESPACE
