#include "backends/record_members.h"

#include <fmt/format.h>

#include <cmath>

#include "backends/read_runs.h"

namespace plait::bench {

using nlohmann::json;

const json& member(const json& object, const char* name) {
  static const json kAbsent;
  if (!object.is_object()) {
    if (object.is_null()) return kAbsent;
    throw BadRecord{
        fmt::format("expected an object around '{}', found {}", name, object.type_name())};
  }
  const auto at = object.find(name);
  return at == object.end() ? kAbsent : *at;
}

std::string cut(std::string text) {
  if (text.size() <= kMostText) return text;
  std::size_t end = kMostText;
  // A byte 10xxxxxx continues a character.
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80) --end;
  text.resize(end);
  return text + "…";
}

std::string text_of(const json& object, const char* name) {
  const json& value = member(object, name);
  if (value.is_null()) return {};
  if (!value.is_string())
    throw BadRecord{fmt::format("'{}': expected text, found {}", name, value.type_name())};
  return cut(value.get<std::string>());
}

std::optional<double> number_of(const json& object, const char* name) {
  const json& value = member(object, name);
  if (value.is_null()) return {};
  if (!value.is_number() || !std::isfinite(value.get<double>()) || value.get<double>() < 0)
    throw BadRecord{fmt::format("'{}': expected a number of at least 0, found {}", name,
                                value.is_number() ? "another number" : value.type_name())};
  return value.get<double>();
}

std::optional<bool> truth_of(const json& object, const char* name) {
  const json& value = member(object, name);
  if (value.is_null()) return {};
  if (!value.is_boolean())
    throw BadRecord{fmt::format("'{}': expected true or false, found {}", name, value.type_name())};
  return value.get<bool>();
}

}  // namespace plait::bench
