#include "plait/attribute.h"

#include "base/text.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr NameTable<ComponentType, 10> kTypes("component type",
                                              {{ComponentType::kFloat32, "float32"},
                                               {ComponentType::kFloat64, "float64"},
                                               {ComponentType::kInt8, "int8"},
                                               {ComponentType::kInt16, "int16"},
                                               {ComponentType::kInt32, "int32"},
                                               {ComponentType::kInt64, "int64"},
                                               {ComponentType::kUint8, "uint8"},
                                               {ComponentType::kUint16, "uint16"},
                                               {ComponentType::kUint32, "uint32"},
                                               {ComponentType::kUint64, "uint64"}});

}  // namespace

std::string_view to_string(ComponentType type) noexcept { return kTypes.name_of(type); }

PLAIT_END_NAMESPACE
