#include <fmt/format.h>

#include "format/file_names.h"
#include "format/manifest.h"
#include "io/machine.h"
#include "maintenance/block_repair.h"
#include "maintenance/file_repair.h"
#include "maintenance/read_block.h"
#include "plait/error.h"
#include "plait/extend/store_access.h"
#include "plait/verify.h"
#include "store/left_overs.h"
#include "store/recovery.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::size_t kMaxNamed = 1000;

Store open_store(const std::filesystem::path& path, const RepairOptions& options,
                 const BackendRegistry& backends) {
  OpenOptions open;
  open.writable = !options.dry_run;
  open.budget_bytes = options.budget_bytes;
  return Store::open(path, open, backends);
}

DamagedBlock describe_block(const Store& store, const BlockAddress& at) {
  const LevelFile& file = StoreAccess::level_file(store, at.attribute, at.level);
  return {store.attributes()[at.attribute].schema.name,
          at.level,
          at.block,
          file.table[at.block].offset,
          file.geometry.first_edge(at.block),
          file.geometry.edge_after(at.block),
          {}};
}

/// Reads rebuilt blocks from their files, and so checks their checksums. The bytes may come from
/// the page cache.
void read_back(Store& store, const std::vector<BlockAddress>& blocks) {
  std::vector<std::byte> buffer;
  for (const BlockAddress& at : blocks) {
    LevelFile& file = StoreAccess::level_file(store, at.attribute, at.level);
    buffer.resize(file.geometry.block_bytes(at.block));
    read_block(store, at.attribute, at.level, at.block, buffer);
  }
}

/// A file that open() still refuses counts as not rebuilt.
void check_rebuilt_files(const std::filesystem::path& path, const BackendRegistry& backends,
                         RepairReport& report) {
  if (report.rebuilt_files.empty()) return;
  const StoreCheck now = check_store(path, backends);
  for (const DamagedFile& damaged : now.damaged) {
    const auto named = [&](const RepairedFile& file) { return file.name == damaged.name; };
    if (std::erase_if(report.rebuilt_files, named) > 0)
      report.lost_files.push_back(
          {damaged.name, fmt::format("it was made anew and is damaged: {}", damaged.reason)});
  }
}

void repair_blocks(Store& store, const RepairOptions& options, MadeAgain& made, BlockProof& proof,
                   RepairReport& report) {
  std::vector<BlockAddress> damaged;
  const VerifyReport found =
      verify(store, options.progress, [&](const BlockAddress& block) { damaged.push_back(block); });
  report.blocks_examined = true;
  report.blocks = found.blocks;
  report.bytes = found.bytes;
  report.version = store.sequence();
  BlockRepair blocks(store, options, made, proof);
  std::vector<BlockAddress> rebuilt;
  for (std::size_t at = 0; at < damaged.size(); ++at) {
    if (options.progress && !options.progress({"make again", at, damaged.size()}))
      throw Error(ErrorCode::kCancelled,
                  fmt::format("repair {}: cancelled", store.path().native()));
    const std::optional<std::string> why_lost = blocks.why_lost(damaged[at]);
    if (!why_lost) rebuilt.push_back(damaged[at]);
    ++(why_lost ? report.lost_count : report.rebuilt_count);
    std::vector<DamagedBlock>& named = why_lost ? report.lost : report.rebuilt;
    if (named.size() >= kMaxNamed) continue;
    // verify() gives a reason for its first blocks only. The others are described without one.
    named.push_back(at < found.damaged.size() ? found.damaged[at]
                                              : describe_block(store, damaged[at]));
    if (why_lost) named.back().reason += fmt::format("; it cannot be rebuilt: {}", *why_lost);
  }
  if (rebuilt.empty() || options.dry_run) return;
  StoreAccess::pager(store).flush();
  store.commit();
  report.version = store.sequence();
  read_back(store, rebuilt);
}

/// The backend of the store. If the description that names it is lost, any backend with raw files,
/// because no level is read then.
std::string backend_of(const StoreCheck& check, const BackendRegistry& backends) {
  if (check.options.backend != kAutomaticBackend) return check.options.backend;
  for (const std::string& name : backends.names())
    if (const BackendTraits traits = backends.find(name).traits;
        traits.durable && !traits.compressed)
      return name;
  return check.options.backend;
}

/// Blocks of a store in shards are made again by the part that made them.
void refuse_shards(const std::filesystem::path& path) {
  bool has_shards = false;
  try {
    has_shards = (read_manifest(open_store_directory(path)).required_features & kShards) != 0;
  } catch (const Error&) {  // repair finds out what is wrong
  }
  if (has_shards)
    throw Error(
        ErrorCode::kNotSupported,
        fmt::format("repair {}: its levels are in shards; make the shards that plait verify "
                    "names again with plait part --again, and join the plan again",
                    path.native()));
}

}  // namespace

RepairReport repair(const std::filesystem::path& path, const RepairOptions& options,
                    const BackendRegistry& backends,
                    const std::shared_ptr<const BlockMakers>& makers) {
  refuse_shards(path);
  RepairReport report;
  // The scratch directory is named after the store, and the path "." has no name.
  UnpublishedDirectory scratch(absolute_path(path), "repair", MadeProof::kMark, remove_made_files);
  StoreCheck check = check_store(path, backends);
  report.files = check.files;
  report.left_over = check.left_over;
  report.notes = check.notes;
  report.version = check.sequence;
  MadeAgain made(check, makers);
  BlockProof proof(backends.find(backend_of(check, backends)), scratch);
  if (!check.lock.empty() && !options.dry_run) make_lock_anew(open_store_directory(path));
  FileRepair files(path, check, options, made, proof, scratch, report);
  files.run();
  if (!options.dry_run) check_rebuilt_files(path, backends, report);
  std::filesystem::path readable = path;
  if (options.dry_run && report.lost_files.empty() && !report.rebuilt_files.empty())
    readable = files.make_view();
  if (!check.lock.empty()) report.rebuilt_files.push_back({kLockName, check.lock});
  if (!report.lost_files.empty()) return report;

  Store store = open_store(readable, options, backends);
  repair_blocks(store, options, made, proof, report);
  store.close();
  for (std::vector<DamagedBlock>* blocks : {&report.rebuilt, &report.lost})
    for (DamagedBlock& block : *blocks)
      block.reason = with_final_name({ErrorCode::kCorruption, block.reason},
                                     readable == path ? "" : readable, path)
                         .what();
  return report;
}

PLAIT_END_NAMESPACE
