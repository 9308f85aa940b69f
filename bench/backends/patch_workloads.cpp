#include "backends/patch_workloads.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <atomic>
#include <chrono>
#include <exception>
#include <thread>

#include "backends/measured_store.h"
#include "base/stopwatch.h"
#include "instrument/random_faces.h"
#include "plait/reader.h"

namespace plait::bench {
namespace {

using Clock = std::chrono::steady_clock;
using Position = Vector3<float>;

/// A slow disk serves so many in a second or two; on a fast one the run is repeated.
constexpr std::size_t kRequests = 160;
constexpr double kOpenLoopSeconds = 3;

/// Reads one patch and adds its hash, without the lowest bits, to `sum`.
std::uint64_t read_and_hash(const Reader& reader, FaceId face, int level, double& seconds,
                            Clock::time_point since) {
  thread_local std::vector<Position> records;
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
  std::uint64_t sum = 0;
  double seconds = 0;
};

Requests read_patches(const Reader& reader, const std::vector<FaceId>& faces, const Cell& cell) {
  const auto threads = static_cast<std::size_t>(cell.threads);
  std::vector<std::vector<double>> latencies(threads);
  std::vector<std::exception_ptr> failures(threads);
  std::atomic<std::uint64_t> sum = 0;
  const Clock::time_point start = Clock::now();
  {
    std::vector<std::jthread> workers;
    for (std::size_t worker = 0; worker < threads; ++worker)
      workers.emplace_back([&, worker] {
        try {
          for (std::size_t at = worker; at < faces.size(); at += threads) {
            Clock::time_point since = Clock::now();
            if (cell.rate > 0) {
              since =
                  start + std::chrono::duration_cast<Clock::duration>(
                              std::chrono::duration<double>(static_cast<double>(at) / cell.rate));
              std::this_thread::sleep_until(since);
            }
            double seconds = 0;
            sum += read_and_hash(reader, faces[at], cell.levels, seconds, since);
            latencies[worker].push_back(seconds);
          }
        } catch (...) {
          failures[worker] = std::current_exception();
        }
      });
  }
  Requests done;
  done.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  for (const std::exception_ptr& failure : failures)
    if (failure) std::rethrow_exception(failure);
  for (const std::vector<double>& of_worker : latencies)
    done.latencies.insert(done.latencies.end(), of_worker.begin(), of_worker.end());
  done.sum = sum;
  return done;
}

nlohmann::ordered_json result_of(const Store& store, const WorkloadRun& run, double seconds) {
  nlohmann::ordered_json result = counted(store, run, seconds);
  // What a request needs beyond its patch depends on the blocks, so the pager's bytes count.
  result["needed_read"] = result["moved_read"];
  result["needed_written"] = 0;
  return result;
}

}  // namespace

nlohmann::ordered_json patch_random(const WorkloadRun& run) {
  const Store store = open_for_reading(run);
  const Reader reader(store, {.attributes = {kAttribute}});
  const std::size_t count =
      run.cell.rate > 0
          ? std::max<std::size_t>(static_cast<std::size_t>(run.cell.rate * kOpenLoopSeconds), 20)
          : kRequests;
  const Requests done = read_patches(
      reader, instrument::draw_faces(false, store.base().face_count(), count, run.seed), run.cell);
  nlohmann::ordered_json result = result_of(store, run, done.seconds);
  result["latencies"] = latencies_to_json(done.latencies);
  if (run.cell.rate > 0) result["open_loop"] = {{"rate", run.cell.rate}, {"from", "scheduled"}};
  result["digest"] = {{"of", fmt::format("{} uniform patches of {}, seed {}", count,
                                         surface_name(run.cell), run.seed)},
                      {"value", fmt::format("{:016x}", done.sum)}};
  return result;
}

nlohmann::ordered_json scan_export(const WorkloadRun& run) {
  const Stopwatch clock;
  const Store store = open_for_reading(run);
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
  nlohmann::ordered_json result = result_of(store, run, clock.seconds());
  result["needed_read"] = needed;
  result["digest"] = {{"of", "export of " + surface_name(run.cell)},
                      {"value", fmt::format("{:016x}", sum)}};
  return result;
}

}  // namespace plait::bench
