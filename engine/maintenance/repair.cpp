#include "plait/repair.h"

#include <fmt/format.h>

#include "maintenance/block_repair.h"
#include "maintenance/file_repair.h"
#include "maintenance/read_block.h"
#include "plait/error.h"
#include "plait/left_overs.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::size_t kMaxNamed = 1000;

Store open_store(const std::filesystem::path& path, const RepairOptions& options,
                 const BackendRegistry& backends) {
  OpenOptions open;
  open.writable = !options.dry_run;
  open.budget_bytes = options.budget_bytes / 2;
  return Store::open(path, open, backends);
}

DamagedBlock describe_block(const Store& store, const BlockAddress& at) {
  const LevelFile& file = store.level_file(at.attribute, at.level);
  return {store.attributes()[at.attribute].schema.name,
          at.level,
          at.block,
          file.table[at.block].offset,
          file.geometry.first_edge(at.block),
          file.geometry.edge_after(at.block),
          {}};
}

/// The blocks that were written are what is stored now, as far as the operating system says.
void read_back(Store& store, const std::vector<BlockAddress>& blocks) {
  std::vector<std::byte> buffer;
  for (const BlockAddress& at : blocks) {
    LevelFile& file = store.level_file(at.attribute, at.level);
    buffer.resize(file.geometry.block_bytes(at.block));
    read_block(store, at.attribute, at.level, at.block, buffer);
  }
}

/// What is damaged all the same, by the rules of opening, was not rebuilt.
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

void repair_blocks(Store& store, const RepairOptions& options, RecomputedStore& recomputed,
                   BlockProof& proof, RepairReport& report) {
  std::vector<BlockAddress> damaged;
  const VerifyReport found = verify(
      store,
      [&](std::uint64_t done, std::uint64_t total) {
        return !options.proceed || options.proceed("verify", done, total);
      },
      [&](const BlockAddress& block) { damaged.push_back(block); });
  report.blocks_examined = true;
  report.blocks = found.blocks;
  report.bytes = found.bytes;
  report.version = store.sequence();
  BlockRepair blocks(store, damaged, options, recomputed, proof);
  blocks.run();

  std::vector<BlockAddress> rebuilt;
  for (std::size_t at = 0; at < damaged.size(); ++at) {
    const bool is_rebuilt = blocks.rebuilt()[at];
    if (is_rebuilt) rebuilt.push_back(damaged[at]);
    ++(is_rebuilt ? report.rebuilt_count : report.lost_count);
    std::vector<DamagedBlock>& named = is_rebuilt ? report.rebuilt : report.lost;
    if (named.size() >= kMaxNamed) continue;
    // Verify names as many; what it only counts is described without its reason.
    named.push_back(at < found.damaged.size() ? found.damaged[at]
                                              : describe_block(store, damaged[at]));
    if (!is_rebuilt)
      named.back().reason +=
          fmt::format("; it cannot be rebuilt: {}", blocks.why_lost(damaged[at]));
  }
  if (rebuilt.empty() || options.dry_run) return;
  store.commit();
  report.version = store.sequence();
  read_back(store, rebuilt);
}

}  // namespace

RepairReport repair(const std::filesystem::path& path, const RepairOptions& options,
                    const BackendRegistry& backends, const PlanRecomputation& recompute) {
  RepairReport report;
  // A store may be given as ".", whose name only the path from the root tells.
  PartialDirectory scratch(std::filesystem::absolute(path), "repair", remove_made_files);
  StoreCheck check = check_store(path, backends);
  report.files = check.files;
  report.left_over = check.left_over;
  report.notes = check.notes;
  report.version = check.sequence;
  RecomputedStore recomputed(check, options, backends, scratch, recompute);
  BlockProof proof(backends.find(check.options.backend),
                   BackendRegistry::options_in(check.options.backend), scratch);
  FileRepair(path, check, options, recomputed, proof, scratch, report).run();
  if (!options.dry_run) check_rebuilt_files(path, backends, report);
  if (!report.lost_files.empty() || (options.dry_run && !report.rebuilt_files.empty()))
    return report;

  Store store = open_store(path, options, backends);
  repair_blocks(store, options, recomputed, proof, report);
  store.close();
  return report;
}

PLAIT_END_NAMESPACE
