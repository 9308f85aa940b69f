#include "maintenance/decoded_again.h"

#include <fmt/format.h>

#include "base/text.h"
#include "plait/extend/pager.h"
#include "plait/extend/store_access.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// A pass over one level after another reads blocks of coarser levels about 4/3 times if the budget
/// does not hold them.
constexpr double kTimesToTell = 1.5;

}  // namespace

std::string decoded_again(const Store& store) {
  std::uint64_t blocks = 0;
  bool need_others = false;
  for (AttributeId id = 0; id < store.attributes().size(); ++id)
    for (int level = store.base_level() + 1; level <= store.attributes()[id].finest_level;
         ++level) {
      const LevelFile& file = StoreAccess::level_file(store, id, level);
      blocks += file.geometry.block_count();
      need_others |= needs_other_blocks(file);
    }
  const Pager& pager = StoreAccess::pager(store);
  const auto reads = static_cast<double>(pager.statistics().blocks_read);
  const double times = reads / static_cast<double>(blocks);
  if (!need_others || times < kTimesToTell) return {};
  return fmt::format(
      "{}: each block was decoded {:.1f} times on average, because its share of the "
      "budget, {}, has no room for the blocks that others are decoded with; more "
      "memory makes this faster (--memory)",
      store.path().native(), times, format_bytes(pager.budget_bytes()));
}

PLAIT_END_NAMESPACE
