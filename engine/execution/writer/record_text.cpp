#include "execution/writer/record_text.h"

#include <fmt/format.h>

#include <cstdint>
#include <cstring>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

template <class Number>
std::string number_text(const std::byte* from) {
  Number number;
  std::memcpy(&number, from, sizeof number);
  return fmt::format("{}", number);
}

std::string component_text(ComponentType type, const std::byte* from) {
  switch (type) {
    case ComponentType::kFloat32:
      return number_text<float>(from);
    case ComponentType::kFloat64:
      return number_text<double>(from);
    case ComponentType::kInt8:
      return number_text<std::int8_t>(from);
    case ComponentType::kInt16:
      return number_text<std::int16_t>(from);
    case ComponentType::kInt32:
      return number_text<std::int32_t>(from);
    case ComponentType::kInt64:
      return number_text<std::int64_t>(from);
    case ComponentType::kUint8:
      return number_text<std::uint8_t>(from);
    case ComponentType::kUint16:
      return number_text<std::uint16_t>(from);
    case ComponentType::kUint32:
      return number_text<std::uint32_t>(from);
    case ComponentType::kUint64:
      return number_text<std::uint64_t>(from);
  }
  return {};
}

}  // namespace

std::string record_text(const AttributeSchema& schema, std::span<const std::byte> record) {
  const std::size_t bytes = component_bytes(schema.type);
  std::string text = component_text(schema.type, record.data());
  if (schema.components == 1) return text;
  for (std::size_t at = 1; at < schema.components; ++at)
    text += ", " + component_text(schema.type, record.data() + at * bytes);
  return "(" + text + ")";
}

PLAIT_END_NAMESPACE
