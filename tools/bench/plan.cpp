#include "bench/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "bench/workloads.h"
#include "plait/attribute.h"
#include "plait/byte_text.h"
#include "plait/error.h"

namespace plait::bench {
namespace {

struct Subject {
  std::string backend, pipeline;
};

std::vector<Subject> subjects(const PlanRequest& request, const BackendRegistry& backends,
                              Plan& plan) {
  std::vector<std::string> names;
  for (const std::string& name : request.backends)
    if (name != "all")
      names.push_back(name);
    else
      for (const std::string& known : backends.names()) {
        const BackendRegistry::Entry& entry = backends.find(known);
        if (!entry.traits.durable) {
          plan.left_out.push_back(fmt::format("{}: keeps no files", known));
          continue;
        }
        try {
          if (entry.validate) entry.validate("");
          names.push_back(known);
        } catch (const Error& error) {
          plan.left_out.push_back(fmt::format("{}: {}", known, error.what()));
        }
      }
  const AttributeSchema schema{"position", ComponentType::kFloat32, 3};
  std::vector<Subject> subjects;
  for (const std::string& name : names) {
    const BackendRegistry::Entry& entry = backends.find(name);
    if (!entry.traits.durable)
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("plan: backend {} keeps no files to measure", name));
    if (entry.validate) entry.validate(BackendRegistry::options_in(name));
    if (!entry.traits.compressed) {
      subjects.push_back({name, "none"});
      continue;
    }
    std::vector<std::string> pipelines = request.codecs;
    if (pipelines.empty()) pipelines = {entry.default_pipeline};
    for (const std::string& pipeline : pipelines) {
      if (entry.validate_pipeline) entry.validate_pipeline(pipeline, schema);
      if (entry.needs_other_blocks && entry.needs_other_blocks(pipeline, schema))
        throw Error(ErrorCode::kNotSupported,
                    fmt::format("plan: pipeline {} encodes blocks from other blocks, and the "
                                "workloads write all levels at once",
                                pipeline));
      subjects.push_back({name, pipeline});
    }
  }
  return subjects;
}

std::vector<std::string> names_of_workloads(const PlanRequest& request) {
  std::vector<std::string> names;
  for (const std::string& name : request.workloads)
    if (name == "all")
      for (const Workload& workload : workloads()) names.emplace_back(workload.name);
    else
      names.emplace_back(workload_from_name(name).name);
  return names;
}

constexpr double kGuessedRate = 300e6;

void add_costs(const PlanRequest& request, Plan& plan) {
  std::map<std::string, std::set<std::string>> stores;
  std::map<std::string, std::uint64_t> bytes, largest;
  double moved = 0;
  for (const Cell& cell : plan.cells) {
    const std::string& directory = cell.directory.native();
    moved += 2 * static_cast<double>(cell.raw_bytes()) * request.rounds;
    largest[directory] = std::max(largest[directory], cell.raw_bytes());
    if (!stores[directory].insert(store_name(cell)).second) continue;
    bytes[directory] += cell.raw_bytes();
    moved += 3 * static_cast<double>(cell.raw_bytes());
  }
  for (PlannedDisk& disk : plan.disks) {
    const std::string& directory = disk.facts.directory.native();
    // Beside the stores: a new store or generation, a floor's file, and one that a floor writes.
    disk.needed_bytes = bytes[directory] + 3 * largest[directory];
  }
  plan.minutes = moved / kGuessedRate / 60;
}

}  // namespace

Plan make_plan(const PlanRequest& request, const BackendRegistry& backends) {
  Plan plan;
  const std::vector<Subject> all = subjects(request, backends, plan);
  const std::vector<std::string> names = names_of_workloads(request);
  for (const std::filesystem::path& directory : request.directories) {
    plan.disks.push_back({instrument::disk_facts(directory), 0});
    const instrument::DiskFacts& facts = plan.disks.back().facts;
    for (const std::uint64_t memory : request.memory)
      for (const double size : request.vertices > 0 ? std::vector<double>{1} : request.sizes)
        for (const std::uint64_t block : request.blocks)
          for (const int threads : request.threads)
            for (const Subject& subject : all)
              for (const std::string& workload : names) {
                Cell cell{.backend = subject.backend,
                          .pipeline = subject.pipeline,
                          .disk = facts.name(),
                          .directory = facts.directory,
                          .workload = workload,
                          .levels = request.levels,
                          .memory_bytes = memory,
                          .budget_bytes = memory / 4,
                          .block_bytes = block,
                          .threads = threads};
                const std::uint64_t base =
                    request.vertices > 0
                        ? request.vertices
                        : static_cast<std::uint64_t>(size * static_cast<double>(memory) / 12) >>
                              (2 * request.levels);
                cell.vertices = std::max<std::uint64_t>(base, 64) << (2 * request.levels);
                cell.durable = workload != "sweep-update";
                if (workload == "patch-random" || workload == "patch-zipf")
                  cell.rate = request.rate;
                plan.cells.push_back(cell);
              }
  }
  add_costs(request, plan);
  return plan;
}

std::vector<std::string> refusals(const Plan& plan, std::uint64_t limit_bytes) {
  std::vector<std::string> lines;
  for (const PlannedDisk& disk : plan.disks) {
    std::uint64_t usable = instrument::usable_bytes(disk.facts);
    if (disk.needed_bytes > usable)
      lines.push_back(fmt::format(
          "measure {}: needs {}, and {} may be used so that a tenth of the disk stays free",
          disk.facts.directory.native(), format_bytes(disk.needed_bytes), format_bytes(usable)));
    else if (limit_bytes != 0 && disk.needed_bytes > limit_bytes)
      lines.push_back(fmt::format("measure {}: needs {}, and --limit is {}",
                                  disk.facts.directory.native(), format_bytes(disk.needed_bytes),
                                  format_bytes(limit_bytes)));
  }
  return lines;
}

std::string to_text(const Plan& plan) {
  std::string text = fmt::format("{} cells:\n", plan.cells.size());
  for (const Cell& cell : plan.cells)
    text +=
        fmt::format("  {}, {}, {}, {}, {} in blocks of {}, memory {}, {} threads\n", cell.disk,
                    cell.backend, cell.pipeline, cell.workload, format_bytes(cell.raw_bytes()),
                    format_bytes(cell.block_bytes), format_bytes(cell.memory_bytes), cell.threads);
  for (const PlannedDisk& disk : plan.disks)
    text += fmt::format("{}: {}, needs {} of {} free\n", disk.facts.directory.native(),
                        disk.facts.name(), format_bytes(disk.needed_bytes),
                        format_bytes(disk.facts.free_bytes));
  for (const std::string& line : plan.left_out) text += fmt::format("left out: {}\n", line);
  return text + fmt::format("about {:.0f} minutes, if every disk moves 300 MB/s\n", plan.minutes);
}

}  // namespace plait::bench
