// tools/build_report.h: what this build of plait contains, and what its plug-ins add.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "plait/extend/plugins.h"

namespace plait {

/// {"version", "compiler", "backends": [{"name", "summary", "available", "reason"}], "codecs",
/// "filters", "schemes", "plugins": [{"file", "backends", "codecs", "filters"}]}. `reason` is there
/// if a backend cannot be used on this machine. Backends, codecs and filters are the built-in ones
/// and those of plug-ins; `plugins` tells which plug-in added what.
nlohmann::ordered_json build_report(const Plugins& plugins);
/// The same as lines of text.
std::string build_text(const nlohmann::ordered_json& report);

}  // namespace plait
