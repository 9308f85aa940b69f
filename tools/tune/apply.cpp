#include "tune/apply.h"

#include <fmt/format.h>

#include "plait/block_table.h"
#include "plait/copy_levels.h"
#include "plait/partial_store.h"
#include "plait/stopwatch.h"
#include "tune/store_copies.h"

namespace plait::tune {
namespace {

double table_bytes(const Store& store) {
  std::uint64_t blocks = 0;
  for (const AttributeId id : refined_attributes(store))
    for (int level = store.base_level() + 1; level <= store.attributes()[id].finest_level; ++level)
      blocks += store.level_file(id, level).table.size();
  return static_cast<double>(blocks * sizeof(BlockEntry));
}

}  // namespace

Applied apply(Store& source, const Findings& findings, const Advice& advice,
              const std::filesystem::path& out, bool force, const BackendRegistry& backends,
              const std::function<bool(std::uint64_t, std::uint64_t)>& proceed) {
  Applied applied;
  applied.predicted = predict(work_of(findings.trials, advice.pick), findings.machine());
  for (const Work& work : work_of(findings.trials, advice.pick))
    applied.predicted_bytes += work.stored_bytes;
  PartialStore output(out, force ? Existing::kReplace : Existing::kRefuse);
  const Stopwatch clock;
  build_output(output, [&] {
    Store copy = Store::create(output.make(), source.base(),
                               options_of_copy(source, findings.trials, advice.pick), backends);
    copy_levels(source, copy, proceed);
    copy.commit();
    applied.write_seconds = clock.seconds();
    for (AttributeId id = 0; id < copy.attributes().size(); ++id)
      for (int level = copy.base_level() + 1; level <= copy.attributes()[id].finest_level; ++level)
        applied.stored_bytes +=
            static_cast<double>(copy.level_file(id, level).backend->stored_bytes());
    applied.stored_bytes += table_bytes(copy);
    copy.close();
  });
  output.publish(true);
  applied.store = output.final_path();
  const CopyFigures figures = read_cold(applied.store, source.options().budget_bytes, backends);
  applied.is_cold = figures.is_cold;
  applied.read_seconds = sum_of(figures.read_seconds);
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
