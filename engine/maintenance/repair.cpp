#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "base/damage.h"
#include "format/file_names.h"
#include "io/copy_range.h"
#include "io/unpublished.h"
#include "maintenance/read_block.h"
#include "maintenance/remaker.h"
#include "maintenance/repair_files.h"
#include "plait/error.h"
#include "plait/extend/store_access.h"
#include "plait/verify.h"
#include "store/left_overs.h"
#include "store/recovery.h"
#include "store/store_directory.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

DamagedBlock describe_block(const Store& store, const BlockAddress& at) {
  const LevelFile& file = StoreAccess::level_file(store, at.attribute, at.level);
  const EdgeId first = file.geometry.first_edge(at.block),
               after = file.geometry.edge_after(at.block);
  const std::string& name = store.attributes()[at.attribute].schema.name;
  return {name, at.level, at.block, file.table[at.block].offset, first, after, {}};
}

/// Makes the block again and writes it; with options.dry_run, does not write it. Returns why the
/// block is lost, or nothing if it is not.
std::optional<std::string> why_block_lost(Store& store, const BlockAddress& block,
                                          const RepairOptions& options, Remaker& remaker) {
  LevelFile& level = StoreAccess::level_file(store, block.attribute, block.level);
  // Alone, such a block cannot be proven; and blocks that others are encoded from cannot change.
  if (level.is_fixed || level.backend->needs_base_records(level.table.attribute()))
    return "it is encoded from other blocks, and repair cannot encode it again";
  if (!remaker.block(store.attributes()[block.attribute].schema.name, level, block.block))
    return remaker.refusal();
  if (options.dry_run) return std::nullopt;
  const PinnedBlock to =
      StoreAccess::open_session(store).pin(level, block.block, Access::kOverwrite);
  std::ranges::copy(remaker.records(), to.bytes().begin());
  return std::nullopt;
}

void repair_blocks(Store& store, bool in_shards, const RepairOptions& options, Remaker& remaker,
                   RepairReport& report) {
  std::vector<BlockAddress> damaged, rebuilt;
  const VerifyReport found =
      verify(store, options.progress, [&](const BlockAddress& block) { damaged.push_back(block); });
  report.blocks_examined = true;
  report.blocks = found.blocks;
  report.bytes = found.bytes;
  remaker.read_from(store);
  for (std::size_t at = 0; at < damaged.size(); ++at) {
    if (options.progress && !options.progress({"make again", at, damaged.size()}))
      throw Error(ErrorCode::kCancelled,
                  fmt::format("repair {}: cancelled", store.path().native()));
    const std::optional<std::string> why_lost =
        in_shards ? kMakeShardAgain : why_block_lost(store, damaged[at], options, remaker);
    if (!why_lost) rebuilt.push_back(damaged[at]);
    ++(why_lost ? report.lost_count : report.rebuilt_count);
    std::vector<DamagedBlock>& named = why_lost ? report.lost : report.rebuilt;
    if (named.size() >= 1000) continue;
    // verify() gives a reason for its first blocks only. The others are described without one.
    named.push_back(at < found.damaged.size() ? found.damaged[at]
                                              : describe_block(store, damaged[at]));
    if (why_lost) named.back().reason += fmt::format("; it cannot be rebuilt: {}", *why_lost);
  }
  if (rebuilt.empty() || options.dry_run) return;
  StoreAccess::pager(store).flush();
  store.commit();
  // From their files, which checks their checksums. The bytes may come from the page cache.
  std::vector<std::byte> buffer;
  for (const BlockAddress& at : rebuilt) {
    buffer.resize(
        StoreAccess::level_file(store, at.attribute, at.level).geometry.block_bytes(at.block));
    read_block(store, at.attribute, at.level, at.block, buffer);
  }
}

}  // namespace

RepairReport repair(const std::filesystem::path& path, const RepairOptions& options,
                    const BackendRegistry& backends,
                    const std::shared_ptr<const BlockMakers>& makers) {
  RepairReport report;
  if (!options.dry_run)
    remove_left_overs_of_repairs(open_store_directory(path),
                                 [&](const std::string& what) { report.notes.push_back(what); });
  // Inside the store: what is beside it may be another file system, or not be writable. Only work
  // that needs the directory makes it.
  UnpublishedDirectory scratch(path / kRepairStem, "repair", MadeProof::kMark, remove_made_files);
  const StoreCheck check = check_store(path, backends);
  report.files = check.files;
  report.left_over = check.left_over;
  report.notes.insert(report.notes.end(), check.notes.begin(), check.notes.end());
  report.version = check.sequence;
  Remaker remaker(check, makers, backends, scratch);
  if (!check.lock.empty() && !options.dry_run) make_lock_anew(open_store_directory(path));
  repair_files(path, check, options, remaker, scratch, report);
  std::filesystem::path readable = path;
  if (options.dry_run && report.lost_files.empty() && !report.rebuilt_files.empty()) {
    // With links to the other files, the scratch directory is what the store would be.
    const Directory store(path);
    for (const std::string& name : store.names())
      if (is_store_file_name(name) && name != kLockName && !scratch.directory().contains(name))
        link_file(store, name, scratch.directory());
    readable = scratch.directory().path();
  }
  if (!check.lock.empty()) report.rebuilt_files.push_back({kLockName, check.lock});
  if (!report.lost_files.empty()) return report;

  const bool writable = !options.dry_run && !check.in_shards;
  Store store =
      Store::open(readable, {.writable = writable, .budget_bytes = options.budget_bytes}, backends);
  repair_blocks(store, check.in_shards, options, remaker, report);
  report.version = store.sequence();
  store.close();
  if (readable == path) return report;
  for (std::vector<DamagedBlock>* blocks : {&report.rebuilt, &report.lost})
    for (DamagedBlock& block : *blocks)
      block.reason = with_final_name({ErrorCode::kCorruption, block.reason}, readable, path).what();
  return report;
}

PLAIT_END_NAMESPACE
