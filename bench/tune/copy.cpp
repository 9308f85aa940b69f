#include "tune/copy.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "base/stopwatch.h"
#include "instrument/page_cache.h"
#include "paging/level_cursor.h"
#include "plait/extend/copy_levels.h"
#include "plait/extend/store_access.h"
#include "plait/extend/sweep.h"
#include "plait/store_info.h"

namespace plait::tune {
namespace {

namespace fs = std::filesystem;
/// Shorter reads are repeated.
constexpr double kLeastReadSeconds = 0.3;
constexpr int kMostReads = 8;

StoreOptions options_of_copy(const Store& source, const Choice& choice, Reads reads,
                             const BackendRegistry& backends) {
  StoreOptions options = source.options();
  options.backend = choice.backend;
  options.pipeline = {};
  options.pipeline_of = {};
  options.durability = reads == Reads::kCold ? Durability::kCommit : Durability::kNone;
  options.block_bytes = choice.block_bytes > 0
                            ? choice.block_bytes
                            : block_bytes_of_copy(source.info().backend, options.block_bytes,
                                                  backends.find(choice.backend).traits);
  if (!choice.compress.empty())
    options.pipeline_of = [compression = compression_of(choice)](const AttributeSchema& schema) {
      return compression.pipeline_of(schema);
    };
  return options;
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
    CopyFigures& part = run.parts[at++];
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

/// Adds the seconds of each attribute, which a sweep reads: all levels side by side, in the order
/// of the edges.
void read_levels(const fs::path& path, std::uint64_t budget_bytes, const BackendRegistry& backends,
                 double CopyFigures::*seconds, CopyRun& run) {
  OpenOptions open;
  open.budget_bytes = budget_bytes;
  Store store = Store::open(path, open, backends);
  std::size_t at = 0;
  for (const AttributeId id : refined_attributes(store)) {
    const Stopwatch clock;
    SweepPass pass;
    pass.name = "read";
    pass.accesses = {{id, store.base_level() + 1, store.attributes()[id].finest_level,
                      Access::kRead, Reach::kOwn}};
    pass.kernel = [](const SweepView&, EdgeId, int) {};
    sweep(store, pass, {.threads = 1, .takes_depths = true});
    run.parts[at++].*seconds += clock.seconds();
  }
}

void read_cold(const fs::path& path, std::uint64_t budget_bytes, const BackendRegistry& backends,
               const Proceed& proceed, CopyRun& run) {
  const std::vector<fs::path> files = instrument::files_under(path);
  int reads = 0;
  while (reads == 0 || (reads < kMostReads && run.read_seconds < kLeastReadSeconds)) {
    if (!proceed()) throw Error(ErrorCode::kCancelled, "tune: cancelled");
    run.is_cold = is_cold(instrument::make_cold(files)) && run.is_cold;
    const Stopwatch clock;
    read_levels(path, budget_bytes, backends, &CopyFigures::read_seconds, run);
    run.read_seconds += clock.seconds();
    ++reads;
  }
  run.read_seconds /= reads;
  for (CopyFigures& part : run.parts) part.read_seconds /= reads;
}

/// The bytes of all records up to a level.
std::uint64_t bytes_to_level(const Store& store, int finest_level) {
  std::uint64_t bytes = 0;
  for (const AttributeId id : refined_attributes(store)) {
    const int finest = std::min(finest_level, store.attributes()[id].finest_level);
    for (int level = store.base_level() + 1; level <= finest; ++level)
      bytes += StoreAccess::level_file(store, id, level).geometry.total_bytes();
  }
  return bytes;
}

}  // namespace

Compression compression_of(const Choice& choice) {
  Compression compression;
  for (const std::string& text : choice.compress) compression.add(text);
  return compression;
}

std::string Choice::options() const {
  std::string text = compress.empty() ? "--backend " + backend : "";
  for (const std::string& value : compress)
    text += fmt::format("{}--compress {}", text.empty() ? "" : " ", value);
  return block_bytes == 0 ? text : fmt::format("{} --block {}KiB", text, block_bytes >> 10);
}

Choice choice_of_preset(const std::string& preset, const std::string& raw_backend) {
  if (preset == "none")
    return {.name = preset, .compress = {}, .is_preset = true, .backend = raw_backend};
  return {.name = preset, .compress = {preset}, .is_preset = true};
}

Choice choice_of_pipelines(const std::vector<AttributeSchema>& attributes,
                           const std::vector<Pipeline>& pipelines) {
  Choice choice;
  for (std::size_t at = 0; at < attributes.size(); ++at)
    choice.compress.push_back(fmt::format("{}={}", attributes[at].name, pipelines[at].to_text()));
  choice.name = fmt::format("{}", fmt::join(choice.compress, "; "));
  return choice;
}

Pipeline pipeline_of(const Choice& choice, const AttributeSchema& schema) {
  return choice.compress.empty() ? Pipeline() : compression_of(choice).pipeline_of(schema).of(0);
}

bool store_alike(const Choice& a, const Choice& b, const std::vector<AttributeSchema>& attributes) {
  return a.block_bytes == b.block_bytes &&
         std::ranges::all_of(attributes, [&](const AttributeSchema& schema) {
           return pipeline_of(a, schema) == pipeline_of(b, schema);
         });
}

bool is_refusal(const Error& error) noexcept {
  return error.code() == ErrorCode::kNotSupported || error.code() == ErrorCode::kInvalidArgument;
}

std::vector<AttributeId> refined_attributes(const Store& store) {
  std::vector<AttributeId> ids;
  for (AttributeId id = 0; id < store.attributes().size(); ++id)
    if (store.attributes()[id].finest_level > store.base_level()) ids.push_back(id);
  return ids;
}

std::uint64_t raw_bytes(const Store& store) { return bytes_to_level(store, store.finest_level()); }

CopyRun store_and_read(Store& source, const Choice& choice, const fs::path& path, Reads reads,
                       const BackendRegistry& backends, const Proceed& proceed) {
  CopyRun run;
  const std::uint64_t budget = source.options().budget_bytes;
  try {
    const Stopwatch clock;
    Store copy =
        Store::create(path, source.base(), options_of_copy(source, choice, reads, backends),
                      backends, source.provenance());
    copy_all(source, copy, proceed, run);
    copy.commit();
    run.write_seconds = clock.seconds();
    run.stored_bytes = static_cast<double>(copy.info().stored_bytes);
    count_blocks(copy, run);
    copy.close();
    if (reads == Reads::kCold) read_cold(path, budget, backends, proceed, run);
    read_levels(path, budget, backends, &CopyFigures::warm_seconds, run);
    for (const CopyFigures& part : run.parts) run.warm_seconds += part.warm_seconds;
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
  while (finest < source.finest_level() && bytes_to_level(source, finest + 1) <= most_bytes)
    ++finest;
  const StoreOptions options =
      options_of_copy(source, choice_of_preset("none", "memory"), Reads::kWarmOnly, backends);
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
