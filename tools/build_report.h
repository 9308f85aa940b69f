// tools/build_report.h: what this build of plait contains.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "plait/backend.h"

namespace plait {

/// {"version", "compiler", "backends": [{"name", "summary", "available", "reason"}], "codecs",
/// "filters", "schemes"}. `reason` is there if a backend cannot be used on this machine.
nlohmann::ordered_json build_report(const BackendRegistry& backends);
/// The same as lines of text.
std::string build_text(const nlohmann::ordered_json& report);

}  // namespace plait
