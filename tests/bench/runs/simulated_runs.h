// Records of runs that never ran: seeded noise and drift, so that tests know the truth.
#pragma once

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

namespace plait::test {

/// Times of a disk that drifts from round to round, with noise of a few per cent upwards.
class SimulatedRuns {
 public:
  explicit SimulatedRuns(std::uint64_t seed) : random_(seed) {}

  struct Way {
    std::string backend = "pread", workload = "sweep-read", disk = "ext4 on vda";
    double factor = 1.2;  ///< the true median of the ratio
    double times_memory = 4;
  };

  /// A record of each way in each round.
  std::vector<nlohmann::json> runs(const std::vector<Way>& ways, int rounds) {
    std::vector<nlohmann::json> records;
    for (int round = 0; round < rounds; ++round) {
      const double drift = std::exp(0.15 * normal());
      for (const Way& way : ways) {
        const double floor = 2 * drift * (1 + 0.02 * std::abs(normal()));
        const double seconds = 2 * drift * way.factor * (1 + 0.03 * std::abs(normal()));
        records.push_back(record(way, round, seconds, floor));
      }
    }
    return records;
  }

  static nlohmann::json record(const Way& way, int round, double seconds, double floor) {
    return {
        {"format", "plait-bench-1"},
        {"key", way.backend + "/" + way.workload + "/" + way.disk + "/" +
                    std::to_string(way.times_memory)},
        {"cell",
         {{"backend", way.backend},
          {"pipeline", "none"},
          {"disk", way.disk},
          {"workload", way.workload},
          {"mesh", nullptr},
          {"vertices", 1e6},
          {"levels", 5},
          {"memory", 256 << 20},
          {"budget", 64 << 20},
          {"ratio", way.times_memory},
          {"block_bytes", 262144},
          {"threads", 2},
          {"durable", true}}},
        {"round", round},
        {"order", 0},
        {"seed", 1},
        {"started", "2026-11-23T01:40:0" + std::to_string(round % 10) + "Z"},
        {"outcome", "ok"},
        {"failure", nullptr},
        {"seconds", seconds},
        {"floor", {{"seconds", floor}, {"kind", "read"}, {"method", "own"}}},
        {"floor_by_fio", {{"seconds", floor * 1.02}}},
        {"ratio", seconds / floor},
        {"bytes",
         {{"needed_read", 1e9},
          {"needed_written", nullptr},
          {"moved_read", 1.1e9},
          {"moved_written", nullptr},
          {"device_read", 1.1e9},
          {"device_written", 0},
          {"stored", 1e9}}},
        {"split",
         {{"compute", seconds * 0.3},
          {"wait", seconds * 0.6},
          {"codec", nullptr},
          {"sync", seconds * 0.1}}},
        {"latencies",
         {{"count", 1000},
          {"p50", 1e-4},
          {"p90", 2e-4},
          {"p99", 1e-3},
          {"p999", 5e-3},
          {"max", 9e-3}}},
        {"faults", {{"minor", 100}, {"major", 3}}},
        {"peak_rss", 1 << 28},
        {"processor", {{"user", 1.5}, {"system", 0.5}}},
        {"proofs",
         {{"limit",
           {{"bytes", 256 << 20},
            {"version", 1},
            {"held", true},
            {"peak", 255 << 20},
            {"times_full", 4}}},
          {"cold",
           {{"asked", true},
            {"label", "cold"},
            {"resident_before", 0},
            {"device_read", 1.1e9},
            {"needed_read", 1e9}}},
          {"second_cold", nullptr},
          {"checksums", true},
          {"mode", {{"direct", true}, {"engine", "threads"}, {"maps", false}}},
          {"others", {{"device_read", 0}, {"device_written", 0}}}}},
        {"digest",
         {{"of", way.workload + std::to_string(way.times_memory)}, {"value", "0123456789abcdef"}}},
        {"doubts", nlohmann::json::array()},
        {"environment",
         {{"plait", "0.1.0"},
          {"commit", "abc"},
          {"kernel", "6.1"},
          {"processor", "made up"},
          {"disk", {{"name", way.disk}, {"file_system", "ext4"}, {"free_bytes", 1e12 + round}}}}}};
  }

 private:
  /// Box and Muller's normal numbers; those of the standard library differ between libraries.
  double normal() {
    const double u = (static_cast<double>(random_() >> 11) + 0.5) * 0x1p-53;
    const double v = static_cast<double>(random_() >> 11) * 0x1p-53;
    return std::sqrt(-2 * std::log(u)) * std::cos(6.283185307179586 * v);
  }

  std::mt19937_64 random_;
};

inline void write_lines(const std::filesystem::path& path,
                        const std::vector<nlohmann::json>& records, const std::string& more = "") {
  std::ofstream file(path, std::ios::binary);
  for (const nlohmann::json& record : records) file << record.dump() << '\n';
  file << more;
}

}  // namespace plait::test
