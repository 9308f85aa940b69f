#include "execution/writer/record_text.h"

#include <fmt/format.h>

#include <cstring>

#include "base/number_type.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

std::string component_text(ComponentType type, const std::byte* from) {
  return with_number_type(type, [&]<class Number>(Number number) {
    std::memcpy(&number, from, sizeof number);
    return fmt::format("{}", number);
  });
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
