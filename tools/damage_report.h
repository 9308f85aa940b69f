// tools/damage_report.h: damage as text and as JSON, for verify and repair.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "plait/verify.h"

namespace plait {

nlohmann::ordered_json to_json(const std::vector<DamagedBlock>& blocks);

/// One line for each block, beginning with `word`, and one for those of `count` that are not named.
std::string to_text(std::string_view word, const std::vector<DamagedBlock>& blocks,
                    std::uint64_t count);

/// Lines about what is no damage.
std::string to_text(const std::vector<std::string>& left_over,
                    const std::vector<std::string>& notes);

}  // namespace plait
