// tools/tune/report.h: what `plait tune` found and advises, as text and as JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tune/advice.h"

namespace plait::tune {

std::string to_text(const Findings& findings, const Advice& advice);
nlohmann::ordered_json to_json(const Findings& findings, const Advice& advice);

}  // namespace plait::tune
