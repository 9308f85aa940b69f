// tools/damage_report.h: formats damage as text and as JSON, for verify and repair.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "plait/verify.h"

namespace plait {

nlohmann::ordered_json to_json(const std::vector<DamagedBlock>& blocks);

/// One line for each block, beginning with `word`. If `count` is larger than the number of blocks,
/// another line gives the difference.
std::string to_text(std::string_view word, const std::vector<DamagedBlock>& blocks,
                    std::uint64_t count);

/// Lines about left-over files and other findings that are not damage.
std::string to_text(const std::vector<std::string>& left_over,
                    const std::vector<std::string>& notes);

}  // namespace plait
