#include "made_blocks.h"

#include <fmt/format.h>

#include <string>

#include "argument_text.h"
#include "plait/extend/store_access.h"

namespace plait {

std::string made_blocks_text(const Store& store, AttributeId attribute) {
  const auto& [schema, finest] = store.attributes()[attribute];
  std::uint64_t blocks = 0, made = 0;
  std::string recipe;
  for (int level = store.base_level() + 1; level <= finest; ++level) {
    const LevelFile& file = StoreAccess::level_file(store, attribute, level);
    for (const BlockEntry& entry : file.table.entries()) {
      ++blocks;
      if (entry.encoding != BlockEncoding::kPredicted) continue;
      ++made;
      recipe = file.pipeline.recipe.value_or("");
    }
  }
  if (made == 0) return {};
  return fmt::format("{}: {} of {} blocks take no bytes; reading makes them again ({})\n",
                     schema.name, format_count(made), format_count(blocks), recipe);
}

}  // namespace plait
