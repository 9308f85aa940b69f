// tools/json_text.h: the text of a report.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace plait {

/// `report` as text, with a line feed at its end. Names of files may have bytes that are no UTF-8,
/// which JSON cannot have: each becomes U+FFFD.
template <class Json>
std::string json_text(const Json& report) {
  return report.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace plait
