#include "runs/measured_store.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "compressed/codec_time.h"
#include "generate/generate.h"
#include "instrument/disk.h"
#include "plait/compression.h"
#include "plait/extend/pager.h"
#include "plait/extend/store_access.h"
#include "plait/layout.h"
#include "plait/mesh_io.h"
#include "plait/store_info.h"
#include "plait/subdivide.h"
#include "runs/read_runs.h"

namespace plait::bench {

namespace fs = std::filesystem;

Store open_store(const WorkloadRun& run, bool writable) {
  OpenOptions options;
  options.writable = writable;
  options.budget_bytes = run.cell.budget_bytes;
  return Store::open(run.store, options, *run.backends);
}

namespace {

/// {direct, engine, maps}: whether this process has files of `store` open with O_DIRECT, has an
/// io_uring, and maps such files. The kernel says so, not the backend.
nlohmann::ordered_json effective_mode(const fs::path& store) {
  bool direct = false, ring = false, maps = false;
  const std::string inside = fs::absolute(store).lexically_normal().native() + "/";
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator("/proc/self/fd", ignored)) {
    const std::string target = fs::read_symlink(entry.path(), ignored).native();
    ring = ring || target.find("[io_uring]") != std::string::npos;
    if (!target.starts_with(inside)) continue;
    const int flags = ::fcntl(std::stoi(entry.path().filename().native()), F_GETFL);
    direct = direct || (flags >= 0 && (flags & O_DIRECT) != 0);
  }
  std::ifstream mappings("/proc/self/maps");
  for (std::string line; std::getline(mappings, line);)
    maps = maps || line.find(inside) != std::string::npos;
  return {{"direct", direct}, {"engine", ring ? "io_uring" : "synchronous"}, {"maps", maps}};
}

}  // namespace

Pipeline pipeline_from_name(const std::string& name) {
  const auto& presets = compression_presets();
  return std::ranges::find(presets, name, &CompressionPreset::name) == presets.end()
             ? Pipeline(name)
             : preset_pipeline(name, kSchema);
}

Store refined_store(const WorkloadRun& run, const LaidOutMesh& base) {
  StoreOptions options;
  options.backend = run.cell.backend;
  if (run.cell.pipeline != "none") options.pipeline = pipeline_from_name(run.cell.pipeline);
  options.block_bytes = run.cell.block_bytes;
  options.budget_bytes = run.cell.budget_bytes;
  Store store = Store::create(run.store, base, options, *run.backends);
  add_base_positions(store);
  subdivide(
      store,
      {.executor = ExecutorKind::kFused, .levels = run.cell.levels, .threads = run.cell.threads});
  return store;
}

LaidOutMesh base_mesh(const Cell& cell) {
  return lay_out(cell.mesh_file.empty()
                     ? BaseMesh::build(generate(GeneratorKind::kTorus, cell.base_vertices, 1))
                     : read_base_mesh(cell.mesh_file),
                 LayoutKind::kHilbert);
}

std::string sweep_digest(Store& store, const Cell& cell) {
  struct alignas(64) Sum {
    std::uint64_t value = 0;
    bool torn = false;
  };
  std::vector<Sum> sums(static_cast<std::size_t>(cell.threads));
  sweep_slots(store, cell, Access::kRead,
              [&](std::span<const std::uint32_t> slot, EdgeId edge, int level, int worker) {
                thread_local std::vector<std::uint32_t> words;
                words.assign(slot.begin(), slot.end());
                const std::uint32_t turned = words.empty() ? 0 : words[0] & 1;
                std::uint32_t difference = 0;
                for (std::uint32_t& word : words) {
                  difference |= word ^ turned;
                  word &= ~std::uint32_t{1};
                }
                Sum& sum = sums[static_cast<std::size_t>(worker)];
                sum.value += XXH3_64bits_withSeed(
                    words.data(), words.size() * sizeof(std::uint32_t),
                    std::uint64_t{edge} * 64 + static_cast<std::uint64_t>(level));
                sum.torn = sum.torn || (difference & 1) != 0;
              });
  Sum all;
  for (const Sum& sum : sums) {
    all.value += sum.value;
    all.torn = all.torn || sum.torn;
  }
  return all.torn ? "torn" : fmt::format("{:016x}", all.value);
}

nlohmann::ordered_json latencies_to_json(std::vector<double> seconds) {
  if (seconds.empty()) return nullptr;
  std::ranges::sort(seconds);
  // The smallest one that this number of the requests did not exceed.
  const auto at = [&](double fraction) {
    const auto rank =
        static_cast<std::size_t>(std::ceil(fraction * static_cast<double>(seconds.size())));
    return seconds[std::clamp<std::size_t>(rank, 1, seconds.size()) - 1];
  };
  return {{"count", seconds.size()}, {"p50", at(0.5)},    {"p90", at(0.9)},
          {"p99", at(0.99)},         {"p999", at(0.999)}, {"max", seconds.back()}};
}

nlohmann::ordered_json counted(const Store& store, const WorkloadRun& run, double seconds,
                               const Needed& needed, double sync_seconds) {
  const PagingStatistics paging = store.info().paging;
  const double wait = 1e-9 * static_cast<double>(paging.read_wait_ns + paging.write_wait_ns);
  const double compute = seconds - sync_seconds - wait / run.cell.threads;
  const nlohmann::ordered_json split = {
      {"compute", or_null(compute >= 0, compute)},
      {"wait", wait},
      {"codec", or_null(store.info().backend.compressed,
                        1e-9 * static_cast<double>(codec_nanoseconds() - run.codec_before_ns))},
      {"sync", sync_seconds}};
  nlohmann::ordered_json bytes;
  const auto add = [&](const std::string& what, const instrument::Traffic& traffic) {
    bytes[what + "_read"] = or_null(traffic.known, traffic.bytes_read);
    bytes[what + "_written"] = or_null(traffic.known, traffic.bytes_written);
  };
  add("needed", {true, needed.read.value_or(paging.bytes_read), needed.written});
  add("moved", {true, paging.bytes_read, paging.bytes_written});
  add("device",
      run.disk ? instrument::device_traffic(*run.disk) - run.disk_before : instrument::Traffic{});
  add("process", instrument::process_traffic());
  bytes["blocks_read"] = paging.blocks_read;
  bytes["stored"] = store.info().stored_bytes;
  return {{"seconds", seconds},
          {"bytes", bytes},
          {"split", split},
          {"mode", effective_mode(store.path())}};
}

}  // namespace plait::bench
