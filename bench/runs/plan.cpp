#include "runs/plan.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <bit>
#include <map>
#include <set>
#include <span>

#include "base/text.h"
#include "built_in_backends.h"
#include "instrument/process.h"
#include "io/machine.h"
#include "plait/base_mesh.h"
#include "plait/error.h"
#include "plait/mesh_io.h"
#include "runs/measured_store.h"
#include "runs/workloads.h"

namespace plait::bench {
namespace {

constexpr const char* kAuto = "auto";

struct Subject {
  std::string backend, pipeline;
  bool is_fixed = false;  ///< its levels cannot be changed: blocks are encoded from others
};

void add_once(std::vector<std::string>& lines, const std::string& line) {
  if (std::ranges::find(lines, line) == lines.end()) lines.push_back(line);
}

std::vector<Subject> subjects(const PlanRequest& request, const BackendRegistry& backends,
                              Plan& plan) {
  std::vector<Subject> subjects;
  const auto add = [&](const std::string& name, bool is_named) {
    const RegisteredBackend& entry = backends.find(name);
    if (!entry.traits.durable) {
      if (!is_named) return;
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("plan: backend {} keeps no files to measure", name));
    }
    try {
      entry.check_machine();
      if (entry.name == "uring") check_uring();  // pread would stand in for it
    } catch (const Error& error) {
      if (is_named) throw;
      return plan.left_out.push_back(fmt::format("{}: {}", name, error.what()));
    }
    if (!entry.traits.compressed) return subjects.push_back({name, "none"});
    for (const std::string codec : {"fast", "default"}) {
      const Pipeline pipeline = pipeline_from_name(codec);
      entry.check_pipelines(pipeline, kSchema);
      subjects.push_back({name, codec, entry.needs_other_blocks(pipeline, kSchema)});
    }
  };
  for (const std::string& name : request.backends)
    if (name == kAuto)
      subjects.push_back({name, "none"});
    else if (name != "all")
      add(name, true);
    else
      for (const std::string& known : backends.names()) add(known, false);
  return subjects;
}

std::vector<const Workload*> workloads_of(const PlanRequest& request) {
  std::vector<const Workload*> list;
  for (const std::string& name : request.workloads)
    if (name == "all")
      for (const Workload& workload : workloads()) list.push_back(&workload);
    else
      list.push_back(&workload_from_name(name));
  return list;
}

constexpr double kGuessedRate = 300e6;
/// To start a process, to open its store, and to look at caches and counters.
constexpr double kGuessedSecondsOfRun = 0.3;

/// The minutes are a guess: every cell and its floor move the store's bytes once, and so does
/// making a store twice.
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
  plan.minutes = (moved / kGuessedRate +
                  static_cast<double>(plan.cells.size()) * request.rounds * kGuessedSecondsOfRun) /
                 60;
}

/// Disks with the names that the user gave them, or that the system has for them. Two directories
/// on one disk have the directory in their names, because the name is part of a cell's key.
std::vector<PlannedDisk> disks_of(const PlanRequest& request) {
  std::vector<PlannedDisk> disks;
  for (const DiskPlace& place : request.disks) {
    disks.push_back({instrument::disk_facts(place.directory), place.name, 0});
    if (place.name.empty()) disks.back().name = disks.back().facts.name();
  }
  std::map<std::string, int> times;
  for (const PlannedDisk& disk : disks) ++times[disk.name];
  for (PlannedDisk& disk : disks)
    if (times[disk.name] > 1)
      disk.name = fmt::format("{} at {}", disk.name, disk.facts.directory.native());
  return disks;
}

/// The base meshes that a memory limit asks for: their vertices and those of all levels.
struct Size {
  std::uint64_t base_vertices, vertices;
};
std::vector<Size> sizes_of(const PlanRequest& request, std::uint64_t memory) {
  if (request.mesh) return {{request.mesh->base_vertices, request.mesh->vertices}};
  const int shift = 2 * request.levels;
  const auto of_base = [&](std::uint64_t vertices) {
    const std::uint64_t base = std::max<std::uint64_t>(vertices, 64);
    return Size{base, base << shift};
  };
  if (request.vertices > 0) return {of_base(request.vertices)};
  std::vector<Size> sizes;
  for (const double size : request.sizes)
    sizes.push_back(
        of_base(static_cast<std::uint64_t>(size * static_cast<double>(memory) / 12) >> shift));
  return sizes;
}

/// Says what `auto` is: one of the other backends. The limit around the process is the memory that
/// its page cache has.
void replace_auto(Cell& cell, const BackendRegistry& backends, Plan& plan) {
  const BackendChoice choice =
      backends.choose({cell.directory / "store.plait", cell.raw_bytes(), false,
                       std::min(cell.memory_bytes, available_memory_bytes())});
  add_once(plan.chosen, fmt::format("auto on {}: {}: {}", cell.disk, choice.name, choice.reason));
  cell.backend = choice.name;
  cell.is_auto = true;
}

/// The rest is for the page cache and the process. A quarter would be too little for `default` with
/// blocks of 256 KiB in 16 MiB: to read one of its blocks takes the blocks that it is encoded from.
std::uint64_t budget_of(std::uint64_t memory_bytes) { return memory_bytes / 8 * 3; }

/// A fused build keeps several blocks of each level open, so the budget has room for 16.
std::uint64_t usual_block_bytes(const Cell& cell, const BackendRegistry& backends) {
  constexpr std::uint64_t kLeast = 4 << 10;
  return std::clamp(std::bit_floor(cell.budget_bytes / 16), kLeast,
                    default_block_bytes(backends.find(cell.backend).traits));
}

}  // namespace

MeshSubject mesh_subject(const std::filesystem::path& file, int levels, std::uint64_t most_bytes,
                         int* chosen) {
  const nlohmann::json found = instrument::in_own_process([&]() -> nlohmann::json {
    const BaseMesh mesh = read_base_mesh(file);
    const auto positions = std::as_bytes(std::span(mesh.positions()));
    const auto faces = std::as_bytes(std::span(mesh.faces()));
    const std::uint64_t checksum = XXH3_64bits_withSeed(
        faces.data(), faces.size(), XXH3_64bits(positions.data(), positions.size()));
    int finest = levels;
    while (finest > 1 && counts_at_level(mesh, finest).vertices > most_bytes / 12) --finest;
    return {{"checksum", checksum},
            {"base_vertices", mesh.vertex_count()},
            {"levels", finest},
            {"vertices", counts_at_level(mesh, finest).vertices}};
  });
  if (chosen != nullptr) *chosen = found["levels"].get<int>();
  return {
      file,
      fmt::format("{} {:016x}", file.filename().native(), found["checksum"].get<std::uint64_t>()),
      found["base_vertices"].get<std::uint64_t>(), found["vertices"].get<std::uint64_t>()};
}

Plan make_plan(const PlanRequest& request, const BackendRegistry& backends) {
  Plan plan;
  const std::vector<Subject> all = subjects(request, backends, plan);
  const std::vector<const Workload*> wanted = workloads_of(request);
  plan.disks = disks_of(request);
  const std::vector<std::uint64_t> blocks =
      request.blocks.empty() ? std::vector<std::uint64_t>{0} : request.blocks;
  std::map<std::string, std::size_t> keys;
  const auto add = [&](Cell cell) {
    if (cell.backend == kAuto) replace_auto(cell, backends, plan);
    if (cell.block_bytes == 0) cell.block_bytes = usual_block_bytes(cell, backends);
    const auto [same, is_new] = keys.try_emplace(key_of(cell), plan.cells.size());
    if (is_new)
      plan.cells.push_back(std::move(cell));
    else if (cell.is_auto)
      plan.cells[same->second].is_auto = true;
  };
  for (const PlannedDisk& disk : plan.disks)
    for (const std::uint64_t memory : request.memory)
      for (const Size& size : sizes_of(request, memory))
        for (const std::uint64_t block : blocks)
          for (const int threads : request.threads)
            for (const Subject& subject : all)
              for (const Workload* const workload : wanted) {
                if (subject.is_fixed && workload->changes_store) {
                  add_once(plan.left_out,
                           fmt::format("{} with {}: {} encodes blocks from others, so its records "
                                       "cannot be changed in place",
                                       workload->name, subject.pipeline, subject.pipeline));
                  continue;
                }
                add({.backend = subject.backend,
                     .pipeline = subject.pipeline,
                     .disk = disk.name,
                     .directory = disk.facts.directory,
                     .workload = std::string(workload->name),
                     .mesh = request.mesh ? request.mesh->name : "",
                     .mesh_file = request.mesh ? request.mesh->file : "",
                     .base_vertices = size.base_vertices,
                     .vertices = size.vertices,
                     .levels = request.levels,
                     .memory_bytes = memory,
                     .budget_bytes = budget_of(memory),
                     .block_bytes = block,
                     .threads = threads});
              }
  add_costs(request, plan);
  return plan;
}

std::vector<std::string> refusals(const Plan& plan, std::uint64_t limit_bytes) {
  std::vector<std::string> lines;
  for (const PlannedDisk& disk : plan.disks) {
    const std::uint64_t usable = instrument::usable_bytes(disk.facts);
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
        fmt::format("  {}, {}, {}, {}, {}{} in blocks of {}, memory {}, {} threads\n", cell.disk,
                    cell.backend, cell.pipeline, cell.workload,
                    cell.mesh.empty() ? "" : cell.mesh + ", ", format_bytes(cell.raw_bytes()),
                    format_bytes(cell.block_bytes), format_bytes(cell.memory_bytes), cell.threads);
  for (const PlannedDisk& disk : plan.disks)
    text += fmt::format("{}: {}, needs {} of {} free\n", disk.facts.directory.native(), disk.name,
                        format_bytes(disk.needed_bytes), format_bytes(disk.facts.free_bytes));
  for (const std::string& line : plan.chosen) text += line + "\n";
  for (const std::string& line : plan.left_out) text += fmt::format("left out: {}\n", line);
  return text + fmt::format("about {:.0f} minutes, if every disk moves {:.0f} MB/s\n", plan.minutes,
                            1e-6 * kGuessedRate);
}

}  // namespace plait::bench
