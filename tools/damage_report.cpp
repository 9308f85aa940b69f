#include "damage_report.h"

#include <fmt/format.h>

#include "arguments.h"

namespace plait {

nlohmann::ordered_json to_json(const std::vector<DamagedBlock>& blocks) {
  nlohmann::ordered_json result = nlohmann::ordered_json::array();
  for (const DamagedBlock& block : blocks)
    result.push_back({{"attribute", block.attribute},
                      {"level", block.level},
                      {"block", block.block},
                      {"file_offset", block.file_offset},
                      {"first_edge", block.first_edge},
                      {"edge_after", block.edge_after},
                      {"reason", block.reason}});
  return result;
}

std::string to_text(std::string_view word, const std::vector<DamagedBlock>& blocks,
                    std::uint64_t count) {
  std::string text;
  for (const DamagedBlock& block : blocks)
    text += fmt::format("{}: {}, level {}, block {}, file offset {}, edges {} to {}: {}\n", word,
                        block.attribute, block.level, block.block, block.file_offset,
                        block.first_edge, block.edge_after - 1, block.reason);
  if (count > blocks.size())
    text += fmt::format("{}: and {} blocks more\n", word, format_count(count - blocks.size()));
  return text;
}

std::string to_text(const std::vector<std::string>& left_over,
                    const std::vector<std::string>& notes) {
  std::string text;
  for (const std::string& note : notes) text += fmt::format("note: {}\n", note);
  for (const std::string& name : left_over)
    text += fmt::format("left over: {}: no version refers to it\n", name);
  return text;
}

}  // namespace plait
