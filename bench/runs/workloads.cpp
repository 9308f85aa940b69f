#include "runs/workloads.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <array>
#include <atomic>
#include <chrono>
#include <vector>

#include "base/stopwatch.h"
#include "base/text.h"
#include "instrument/in_threads.h"
#include "instrument/random_faces.h"
#include "plait/digest.h"
#include "plait/extend/store_access.h"
#include "plait/extend/sweep.h"
#include "plait/reader.h"
#include "runs/measured_store.h"

namespace plait::bench {
namespace {

using Clock = std::chrono::steady_clock;
using Position = Vector3<float>;

/// The number that a slow disk serves in a second or two; on a fast one the run is repeated.
constexpr std::size_t kRequests = 160;

/// Reads one patch and returns its hash without the lowest bits. `seconds` becomes the time that it
/// took.
std::uint64_t read_and_hash(const Reader& reader, FaceId face, int level, double& seconds) {
  thread_local std::vector<Position> records;
  const Clock::time_point since = Clock::now();
  const PatchView patch = reader.read_patch(face, level);
  records.resize(patch_vertex_count(patch.size()));
  patch.attribute<Position>(kAttribute).copy_to(records);
  seconds = std::chrono::duration<double>(Clock::now() - since).count();
  auto* const words = reinterpret_cast<std::uint32_t*>(records.data());
  for (std::size_t at = 0; at < 3 * records.size(); ++at) words[at] &= ~1u;
  return XXH3_64bits_withSeed(words, records.size() * sizeof(Position), face);
}

struct Requests {
  std::vector<double> latencies;
  std::atomic<std::uint64_t> sum = 0;
  double seconds = 0;
};

void read_patches(const Reader& reader, const std::vector<FaceId>& faces, const Cell& cell,
                  Requests& done) {
  done.latencies.resize(faces.size());
  const Clock::time_point start = Clock::now();
  instrument::in_threads(cell.threads, [&](std::size_t worker) {
    for (std::size_t at = worker; at < faces.size(); at += static_cast<std::size_t>(cell.threads)) {
      done.sum += read_and_hash(reader, faces[at], cell.levels, done.latencies[at]);
    }
  });
  done.seconds = std::chrono::duration<double>(Clock::now() - start).count();
}

nlohmann::ordered_json build(const WorkloadRun& run) {
  const LaidOutMesh base = base_mesh(run.cell);
  const Stopwatch clock;
  Store store = refined_store(run, base);
  store.finish_encoding();
  const double made = clock.seconds();
  store.commit();
  const double seconds = clock.seconds();
  nlohmann::ordered_json result =
      counted(store, run, seconds, {0, run.cell.raw_bytes()}, seconds - made);
  store.close();
  // What was written is read back, outside the time.
  Store written = open_store(run);
  result["digest"] = {{"of", "built surface of " + surface_name(run.cell)},
                      {"value", digest(written, {.threads = run.cell.threads}).to_string()}};
  return result;
}

nlohmann::ordered_json sweep_read(const WorkloadRun& run) {
  const Stopwatch clock;
  Store store = open_store(run);
  const std::string digest = sweep_digest(store, run.cell);
  const double seconds = clock.seconds();
  std::uint64_t needed = 0;
  for (int level = 1; level <= run.cell.levels; ++level)
    needed +=
        StoreAccess::level_file(store, store.attribute(kAttribute), level).geometry.total_bytes();
  nlohmann::ordered_json result = counted(store, run, seconds, {needed});
  result["digest"] = {{"of", "surface of " + surface_name(run.cell)}, {"value", digest}};
  return result;
}

/// Turns the lowest bit of each number of all levels, and commits.
nlohmann::ordered_json sweep_update(const WorkloadRun& run) {
  const Stopwatch clock;
  Store store = open_store(run, true);
  sweep_slots(store, run.cell, Access::kUpdate,
              [](std::span<std::uint32_t> slot, EdgeId, int, int) {
                for (std::uint32_t& word : slot) word ^= 1;
              });
  const double swept = clock.seconds();
  store.commit();
  const double seconds = clock.seconds();
  nlohmann::ordered_json result =
      counted(store, run, seconds, {run.cell.raw_bytes(), run.cell.raw_bytes()}, seconds - swept);
  store.close();
  Store written = open_store(run);
  result["digest"] = {{"of", "surface of " + surface_name(run.cell)},
                      {"value", sweep_digest(written, run.cell)}};
  return result;
}

/// Each thread reads the next patch when it has the last one (a closed loop).
nlohmann::ordered_json patch_random(const WorkloadRun& run) {
  const Store store = open_store(run);
  const Reader reader(store, {.attributes = {kAttribute}});
  Requests done;
  read_patches(reader,
               instrument::draw_faces(false, store.base().face_count(), kRequests, run.seed),
               run.cell, done);
  nlohmann::ordered_json result = counted(store, run, done.seconds, {});
  result["latencies"] = latencies_to_json(done.latencies);
  result["digest"] = {{"of", fmt::format("{} uniform patches of {}, seed {}", kRequests,
                                         surface_name(run.cell), run.seed)},
                      {"value", fmt::format("{:016x}", done.sum.load())}};
  return result;
}

nlohmann::ordered_json scan_export(const WorkloadRun& run) {
  const Stopwatch clock;
  const Store store = open_store(run);
  const Reader reader(store, {.attributes = {kAttribute}, .policy = EvictionPolicy::kLayoutOrder});
  std::uint64_t sum = 0, needed = 0;
  for (int level = 1; level <= run.cell.levels; ++level)
    reader.for_each_block<Position>(
        kAttribute, level, 0, reader.vertex_count(level),
        [&](std::uint64_t first, std::span<const Position> records) {
          needed += records.size_bytes();
          const auto* const words = reinterpret_cast<const std::uint32_t*>(records.data());
          // Neither the blocks' sizes nor the lowest bits change the sum.
          for (std::size_t at = 0; at < 3 * records.size(); ++at)
            sum += (words[at] | 1) * (2 * (3 * first + at) + static_cast<std::uint64_t>(level));
        });
  nlohmann::ordered_json result = counted(store, run, clock.seconds(), {needed});
  result["digest"] = {{"of", "export of " + surface_name(run.cell)},
                      {"value", fmt::format("{:016x}", sum)}};
  return result;
}

using instrument::FloorKind;
constexpr std::array kWorkloads = {
    Workload{"build", "make all levels from the base mesh (fused), durable", FloorKind::kWrite,
             true, false, false, build},
    Workload{"sweep-read", "read all levels in order", FloorKind::kRead, false, true, false,
             sweep_read},
    Workload{"sweep-update", "read and overwrite all levels, durable", FloorKind::kUpdate, false,
             true, true, sweep_update},
    Workload{"scan-export", "read all vertices level by level, as an export does", FloorKind::kRead,
             false, true, false, scan_export},
    Workload{"patch-random", "read patches, all equally likely", FloorKind::kRandomRead, false,
             false, false, patch_random},
};

}  // namespace

std::span<const Workload> workloads() { return kWorkloads; }

const Workload& workload_from_name(std::string_view name) {
  std::vector<std::string_view> names;
  for (const Workload& workload : kWorkloads) {
    if (workload.name == name) return workload;
    names.push_back(workload.name);
  }
  throw unknown_name("workload", name, names);
}

void prepare_store(const WorkloadRun& run) {
  Store store = refined_store(run, base_mesh(run.cell));
  sweep_slots(store, run.cell, Access::kUpdate,
              [](std::span<std::uint32_t> slot, EdgeId edge, int level, int) {
                std::uint64_t state = std::uint64_t{edge} * 64 + static_cast<std::uint64_t>(level);
                for (std::uint32_t& word : slot) {
                  state = state * 6364136223846793005u + 1442695040888963407u;
                  word = (word & ~0x3fu) | (static_cast<std::uint32_t>(state >> 40) & 0x3eu);
                }
              });
  store.finish_encoding();
  store.commit();
  store.close();
}

}  // namespace plait::bench
