// tools/rounding_report.h: how an attribute was rounded, as the commands print it.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "plait/extend/rounding.h"

namespace plait {

/// "rounded to steps of 2e-5: error at most 1e-5 (component), largest found 9.9e-6, ..."
std::string to_text(const Rounding& rounding);
nlohmann::ordered_json to_json(const Rounding& rounding);

}  // namespace plait
