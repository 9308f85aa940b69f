#include "tune/apply.h"

#include <fmt/format.h>

#include <algorithm>

#include "instrument/page_cache.h"
#include "plait/backends/compression.h"
#include "plait/byte_text.h"
#include "plait/copy_levels.h"
#include "plait/level_cursor.h"
#include "plait/partial_store.h"
#include "plait/stopwatch.h"

namespace plait::tune {
namespace {

StoreOptions options_of_copy(const Store& source, const Findings& findings, const Choice& choice) {
  StoreOptions options = source.options();
  const bool stores_raw = std::ranges::all_of(
      choice.trials, [&](std::size_t at) { return findings.trials.trials[at].pipeline == "none"; });
  options.backend = stores_raw ? "pread" : "compressed";
  options.pipeline = {};
  options.pipeline_of = {};
  options.block_bytes = choice.block_bytes;
  options.durability = Durability::kCommit;
  if (stores_raw) return options;
  Compression compression;
  for (const std::string& argument : compress_arguments(findings.trials, choice))
    compression.add(argument);
  options.pipeline_of = [compression](const AttributeSchema& schema) {
    return compression.pipeline_of(schema);
  };
  return options;
}

}  // namespace

double read_all_levels(const Store& store) {
  const Stopwatch clock;
  for (AttributeId id = 0; id < store.attributes().size(); ++id)
    for (int level = store.base_level() + 1; level <= store.attributes()[id].finest_level;
         ++level) {
      LevelCursor cursor(store.open_session(), store.level_file(id, level));
      for (EdgeId edge = 0; edge < store.base().edge_count(); ++edge) cursor.slot(edge);
    }
  return clock.seconds();
}

Applied apply(Store& source, const Findings& findings, const Advice& advice,
              const std::filesystem::path& out, bool force, const BackendRegistry& backends,
              const std::function<bool(std::uint64_t, std::uint64_t)>& proceed) {
  Applied applied;
  applied.predicted =
      predict(work_of(findings.trials, advice.pick), findings.disk.disk, findings.processors);
  for (const Work& work : work_of(findings.trials, advice.pick))
    applied.predicted_bytes += work.stored_bytes;
  PartialStore output(out, force ? Existing::kReplace : Existing::kRefuse);
  const Stopwatch clock;
  build_output(output, [&] {
    Store copy = Store::create(output.make(), source.base(),
                               options_of_copy(source, findings, advice.pick), backends);
    copy_levels(source, copy, proceed);
    copy.commit();
    applied.write_seconds = clock.seconds();
    for (AttributeId id = 0; id < copy.attributes().size(); ++id)
      for (int level = copy.base_level() + 1; level <= copy.attributes()[id].finest_level; ++level)
        applied.stored_bytes +=
            static_cast<double>(copy.level_file(id, level).backend->stored_bytes());
    copy.close();
  });
  output.publish(true);
  applied.store = output.final_path();
  const auto files = instrument::files_under(applied.store);
  applied.is_cold = is_cold(instrument::make_cold(files));
  OpenOptions open;
  open.budget_bytes = source.options().budget_bytes;
  applied.read_seconds = read_all_levels(Store::open(applied.store, open, backends));
  return applied;
}

std::string to_text(const Applied& applied) {
  const auto line = [](const char* what, double predicted, double found, const char* unit) {
    return fmt::format("  {:<12} predicted {:>9.3f} {}, found {:>9.3f} {} ({:+.0f} %)\n", what,
                       predicted, unit, found, unit, 100 * (found / predicted - 1));
  };
  return fmt::format("\n{}\n", applied.store.native()) +
         line("levels", applied.predicted_bytes / 1048576, applied.stored_bytes / 1048576, "MiB") +
         line("full read", applied.predicted.read, applied.read_seconds, "s") +
         line("full write", applied.predicted.write, applied.write_seconds, "s") +
         (applied.is_cold ? "" : "  the files were in memory while they were read\n") +
         "  the write found here also read the source\n";
}

nlohmann::ordered_json to_json(const Applied& applied) {
  return {{"store", applied.store.string()},
          {"cold", applied.is_cold},
          {"predicted",
           {{"stored_bytes", applied.predicted_bytes},
            {"read_seconds", applied.predicted.read},
            {"write_seconds", applied.predicted.write}}},
          {"found",
           {{"stored_bytes", applied.stored_bytes},
            {"read_seconds", applied.read_seconds},
            {"write_seconds_with_reading_the_source", applied.write_seconds}}}};
}

}  // namespace plait::tune
