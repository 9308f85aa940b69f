#include "tune/copy.h"

#include <algorithm>

#include "base/stopwatch.h"
#include "instrument/page_cache.h"
#include "paging/level_cursor.h"
#include "plait/error.h"
#include "plait/extend/copy_levels.h"
#include "plait/extend/store_access.h"
#include "plait/extend/sweep.h"

namespace plait::tune {
namespace {

namespace fs = std::filesystem;
/// Shorter reads are repeated.
constexpr double kLeastReadSeconds = 0.3;
constexpr int kMostReads = 8;

void check(const Proceed& proceed) {
  if (!proceed()) throw Error(ErrorCode::kCancelled, "tune: cancelled");
}

/// As copy_levels(), with the seconds of each attribute.
void copy_all(Store& source, Store& copy, const Proceed& proceed, CopyRun& run) {
  StoreAccess::set_provenance(copy, source.provenance());
  std::vector<AttributeId> copies;
  for (const AttributeInfo& info : source.attributes())
    copies.push_back(copy.add_attribute(info.schema));
  for (AttributeId id = 0; id < copies.size(); ++id) {
    const Stopwatch clock;
    copy_attribute(source, id, copy, copies[id], [&](const Progress&) { return proceed(); });
    if (source.attributes()[id].finest_level > source.base_level())
      run.parts.push_back({.write_seconds = clock.seconds()});
  }
}

void count_blocks(const Store& copy, CopyRun& run) {
  std::size_t at = 0;
  for (const AttributeId id : refined_attributes(copy)) {
    PartOfCopy& part = run.parts[at++];
    for (int level = copy.base_level() + 1; level <= copy.attributes()[id].finest_level; ++level) {
      const LevelFile& file = StoreAccess::level_file(copy, id, level);
      part.stored_bytes += static_cast<double>(file.backend->stored_bytes() +
                                               file.table.size() * sizeof(BlockEntry));
      part.blocks += file.table.size();
      for (const BlockEntry& entry : file.table.entries())
        part.made_blocks += entry.encoding == BlockEncoding::kPredicted;
      run.can_change = run.can_change && !file.is_fixed;
    }
  }
}

/// The seconds of each attribute, which a sweep reads: all levels side by side, in the order of the
/// edges.
std::vector<double> read_levels(const fs::path& path, std::uint64_t budget_bytes,
                                const BackendRegistry& backends) {
  OpenOptions open;
  open.budget_bytes = budget_bytes;
  Store store = Store::open(path, open, backends);
  std::vector<double> seconds;
  for (const AttributeId id : refined_attributes(store)) {
    const Stopwatch clock;
    SweepPass pass;
    pass.name = "read";
    pass.accesses = {{id, store.base_level() + 1, store.attributes()[id].finest_level,
                      Access::kRead, Reach::kOwn}};
    pass.kernel = [](const SweepView&, EdgeId, int) {};
    sweep(store, pass, {.threads = 1});
    seconds.push_back(clock.seconds());
  }
  return seconds;
}

void read_cold(const fs::path& path, std::uint64_t budget_bytes, const BackendRegistry& backends,
               const Proceed& proceed, CopyRun& run) {
  const std::vector<fs::path> files = instrument::files_under(path);
  int reads = 0;
  double all = 0;
  while (reads == 0 || (reads < kMostReads && all < kLeastReadSeconds)) {
    check(proceed);
    run.is_cold = is_cold(instrument::make_cold(files)) && run.is_cold;
    const Stopwatch clock;
    const std::vector<double> seconds = read_levels(path, budget_bytes, backends);
    all += clock.seconds();
    for (std::size_t at = 0; at < seconds.size(); ++at) run.parts[at].read_seconds += seconds[at];
    ++reads;
  }
  run.read_seconds = all / reads;
  for (PartOfCopy& part : run.parts) part.read_seconds /= reads;
}

}  // namespace

CopyRun store_and_read(Store& source, const Choice& choice, const fs::path& path, Reads reads,
                       const BackendRegistry& backends, const Proceed& proceed) {
  CopyRun run;
  const std::uint64_t budget = source.options().budget_bytes;
  StoreOptions options = options_of_copy(source, choice);
  if (reads == Reads::kWarmOnly) options.durability = Durability::kNone;
  try {
    const Stopwatch clock;
    Store copy = Store::create(path, source.base(), options, backends, source.provenance());
    copy_all(source, copy, proceed, run);
    copy.commit();
    run.write_seconds = clock.seconds();
    run.stored_bytes = static_cast<double>(copy.stored_bytes());
    count_blocks(copy, run);
    copy.close();
    if (reads == Reads::kCold) read_cold(path, budget, backends, proceed, run);
    const std::vector<double> warm = read_levels(path, budget, backends);
    for (std::size_t at = 0; at < warm.size(); ++at) {
      run.parts[at].warm_seconds = warm[at];
      run.warm_seconds += warm[at];
    }
  } catch (...) {
    std::error_code ignored;
    fs::remove_all(path, ignored);
    throw;
  }
  fs::remove_all(path);
  return run;
}

Store coarse_levels_in_memory(const Store& source, std::uint64_t most_bytes,
                              const BackendRegistry& backends) {
  int finest = source.base_level() + 1;
  for (; finest < source.finest_level(); ++finest) {
    std::uint64_t bytes = 0;
    for (const AttributeId id : refined_attributes(source))
      bytes += level_bytes(source, id, finest + 1);
    if (bytes > most_bytes) break;
  }
  StoreOptions options = source.options();
  options.backend = "memory";
  options.pipeline = {};
  options.pipeline_of = {};
  Store copy = Store::create({}, source.base(), options, backends);
  for (const AttributeId id : refined_attributes(source)) {
    const auto& [schema, own_finest] = source.attributes()[id];
    const AttributeId to = copy.add_attribute(schema);
    std::ranges::copy(source.base_bytes(id), copy.base_bytes(to).begin());
    for (int level = source.base_level() + 1; level <= std::min(finest, own_finest); ++level) {
      copy.add_level(to);
      UnfinishedLevels written;
      written.add(StoreAccess::level_file(copy, to, level), Access::kOverwrite);
      LevelCursor from(StoreAccess::open_session(source),
                       StoreAccess::level_file(source, id, level));
      LevelCursor into(StoreAccess::open_session(copy), StoreAccess::level_file(copy, to, level),
                       Access::kOverwrite);
      for (EdgeId edge = 0; edge < source.base().edge_count(); ++edge)
        std::ranges::copy(from.slot(edge).bytes, into.slot(edge).bytes.begin());
      written.finish();
    }
  }
  return copy;
}

}  // namespace plait::tune
