#include "tune/store_copies.h"

#include <algorithm>
#include <numeric>

#include "instrument/page_cache.h"
#include "plait/backends/compression.h"
#include "plait/block_table.h"
#include "plait/error.h"
#include "plait/level_cursor.h"
#include "plait/stopwatch.h"
#include "tune/advice.h"

namespace plait::tune {
namespace {

double stored_bytes_of(const Store& store, AttributeId id) {
  double bytes = 0;
  for (int level = store.base_level() + 1; level <= store.attributes()[id].finest_level; ++level) {
    const LevelFile& file = store.level_file(id, level);
    bytes +=
        static_cast<double>(file.backend->stored_bytes() + file.table.size() * sizeof(BlockEntry));
  }
  return bytes;
}

void copy_level(const Store& source, AttributeId id, int level, Store& copy, AttributeId to,
                const CopyProgress& proceed) {
  const LevelGeometry& geometry = source.level_file(id, level).geometry;
  UnfinishedLevels written;
  written.add(copy.level_file(to, level), Access::kOverwrite);
  LevelCursor from(source.open_session(), source.level_file(id, level));
  LevelCursor into(copy.open_session(), copy.level_file(to, level), Access::kOverwrite);
  for (EdgeId edge = 0; edge < source.base().edge_count(); ++edge) {
    std::ranges::copy(from.slot(edge).bytes, into.slot(edge).bytes.begin());
    const std::uint64_t block = geometry.block_of(edge);
    if (edge + 1 != geometry.edge_after(block)) continue;
    if (!proceed(geometry.block_bytes(block)))
      throw Error(ErrorCode::kCancelled, "tune: cancelled while a store was copied");
  }
  written.finish();
}

}  // namespace

double sum_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

StoreOptions options_of_copy(const Store& source, const Trials& trials, const Choice& choice) {
  StoreOptions options = source.options();
  const bool raw = stores_raw(trials, choice);
  options.backend = raw ? "pread" : "compressed";
  options.pipeline = {};
  options.pipeline_of = {};
  options.block_bytes = choice.block_bytes;
  options.durability = Durability::kCommit;
  if (raw) return options;
  Compression compression;
  for (const std::string& argument : compress_arguments(trials, choice)) compression.add(argument);
  options.pipeline_of = [compression](const AttributeSchema& schema) {
    return compression.pipeline_of(schema);
  };
  return options;
}

std::vector<double> copy_store(const Store& source, const Trials& trials, const Choice& choice,
                               int finest_level, const std::filesystem::path& out,
                               const BackendRegistry& backends, const CopyProgress& proceed) {
  Store copy = Store::create(out, source.base(), options_of_copy(source, trials, choice), backends);
  copy.set_provenance(source.provenance());
  std::vector<double> stored;
  for (const AttributeId id : refined_attributes(source)) {
    const auto& [schema, finest] = source.attributes()[id];
    const AttributeId to = copy.add_attribute(schema);
    std::ranges::copy(source.base_bytes(id), copy.base_bytes(to).begin());
    copy.plan_levels(to, finest, schema.name);
    for (int level = source.base_level() + 1; level <= std::min(finest, finest_level); ++level) {
      copy.add_level(to);
      copy_level(source, id, level, copy, to, proceed);
    }
  }
  copy.commit();
  for (AttributeId id = 0; id < copy.attributes().size(); ++id)
    stored.push_back(stored_bytes_of(copy, id));
  copy.close();
  return stored;
}

CopyFigures read_cold(const std::filesystem::path& path, std::uint64_t budget_bytes,
                      const BackendRegistry& backends) {
  CopyFigures figures;
  figures.is_cold = is_cold(instrument::make_cold(instrument::files_under(path)));
  OpenOptions open;
  open.budget_bytes = budget_bytes;
  const Store store = Store::open(path, open, backends);
  for (const AttributeId id : refined_attributes(store)) {
    const Stopwatch clock;
    for (int level = store.base_level() + 1; level <= store.attributes()[id].finest_level;
         ++level) {
      LevelCursor cursor(store.open_session(), store.level_file(id, level));
      for (EdgeId edge = 0; edge < store.base().edge_count(); ++edge) cursor.slot(edge);
    }
    figures.read_seconds.push_back(clock.seconds());
    figures.stored_bytes.push_back(stored_bytes_of(store, id));
  }
  return figures;
}

std::uint64_t level_bytes(const Store& store, AttributeId id, int finest_level) {
  std::uint64_t bytes = 0;
  const int finest = std::min(finest_level, store.attributes()[id].finest_level);
  for (int level = store.base_level() + 1; level <= finest; ++level)
    bytes += store.level_file(id, level).geometry.total_bytes();
  return bytes;
}

CoarseLevels coarse_levels(const Store& store, std::uint64_t most_bytes) {
  CoarseLevels found;
  for (int level = store.base_level() + 1; level <= store.finest_level(); ++level) {
    std::uint64_t bytes = 0;
    for (const AttributeId id : refined_attributes(store)) bytes += level_bytes(store, id, level);
    if (bytes > most_bytes && level > store.base_level() + 1) break;
    found = {level, bytes};
  }
  return found;
}

std::vector<AttributeId> refined_attributes(const Store& store) {
  std::vector<AttributeId> ids;
  for (AttributeId id = 0; id < store.attributes().size(); ++id)
    if (store.attributes()[id].finest_level > store.base_level()) ids.push_back(id);
  return ids;
}

}  // namespace plait::tune
