#include "cold_patch_reads.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "command_line.h"
#include "confined.h"
#include "plait/backends/registry.h"
#include "plait/reader.h"
#include "random_patches.h"
#include "random_reads.h"
#include "support.h"

namespace plait::bench {
namespace {

namespace fs = std::filesystem;

/// What one run of the child process measures.
struct Figures {
  double seconds, blocks, block_bytes, disk_bytes, p50, p99, p999;

  std::vector<double> values() const {
    return {seconds, blocks, block_bytes, disk_bytes, p50, p99, p999};
  }
  static Figures of(const std::vector<double>& v) {
    return {v.at(0), v.at(1), v.at(2), v.at(3), v.at(4), v.at(5), v.at(6)};
  }
};

struct Row {
  std::string backend, distribution;
  int threads;
  std::vector<Figures> figures = {};
  std::vector<double> floors = {};  ///< bytes a second
  int jobs = 0, depth = 0;          ///< of the floor

  template <class Of>
  double median_of(Of of) const {
    std::vector<double> values;
    for (std::size_t turn = 0; turn < figures.size(); ++turn)
      values.push_back(of(figures[turn], floors[turn]));
    return median(values);
  }
};

/// The bytes that this process has read from the disk; NaN if the kernel does not count them.
double disk_bytes() {
  std::ifstream file("/proc/self/io");
  for (std::string word; file >> word;)
    if (double bytes = 0; word == "read_bytes:" && file >> bytes) return bytes;
  return std::nan("");
}

Figures read_patches(const fs::path& path, const ColdSettings& settings, const Row& row,
                     std::uint64_t budget_bytes, unsigned seed) {
  OpenOptions open;
  open.budget_bytes = budget_bytes;
  if (settings.io_threads >= 0) open.io_threads = settings.io_threads;
  const Store store = Store::open(path, open, default_backends());
  const Reader reader(store);
  const bool zipf = row.distribution == "zipf";
  const std::uint64_t face_count = store.base().face_count();
  // The budget is full before the time begins.
  for (const FaceId face : draw(zipf, face_count, settings.reads, seed + 1000)) {
    if (reader.statistics().blocks_evicted > 0) break;
    static_cast<void>(reader.read_patch(face, settings.level));
  }
  const auto faces = draw_for_threads(row.threads, zipf, face_count, settings.reads, seed);
  std::vector<std::vector<Vector3<float>>> into(
      faces.size(),
      std::vector<Vector3<float>>(patch_vertex_count(std::int64_t{1} << settings.level)));
  const PagingStatistics before = reader.statistics();
  const double disk_before = disk_bytes();
  std::vector<double> times;
  Figures figures{};
  figures.seconds = seconds([&] {
    times = latencies(faces, [&](std::size_t thread, FaceId face) {
      reader.read_patch(face, settings.level)
          .attribute<Vector3<float>>("position")
          .copy_to(into[thread]);
    });
  });
  const PagingStatistics after = reader.statistics();
  figures.disk_bytes = disk_bytes() - disk_before;
  figures.blocks = static_cast<double>(after.blocks_read - before.blocks_read);
  figures.block_bytes = static_cast<double>(after.bytes_read - before.bytes_read);
  figures.p50 = quantile(times, 0.5);
  figures.p99 = quantile(times, 0.99);
  figures.p999 = quantile(times, 0.999);
  return figures;
}

void make_store(const fs::path& path, const BaseMesh& base, const ColdSettings& settings,
                const std::string& backend) {
  fs::remove_all(path);
  StoreOptions options;
  options.backend = backend;
  options.block_bytes = settings.block_kibibytes << 10;
  Store store = Store::create(path, base, options, default_backends());
  add_base_positions(store);
  subdivide(store, {.levels = settings.level});
  store.commit();
}

/// Measures a row once, and its floor right after it.
void measure(Row& row, const fs::path& path, const fs::path& finest, const ColdSettings& settings,
             const MemoryLimit& limit, std::uint64_t budget_bytes, std::uint64_t block_bytes,
             int turn) {
  make_cold({finest});
  const Figures figures = Figures::of(run_for_figures(limit, [&] {
    return read_patches(path, settings, row, budget_bytes, static_cast<unsigned>(100 * turn))
        .values();
  }));
  row.figures.push_back(figures);
  const auto reads = settings.reads / row.threads * row.threads;
  const double blocks_of_read = figures.blocks / static_cast<double>(reads);
  RandomReads floor{.file = finest, .block_bytes = block_bytes};
  if (row.backend == "uring") {
    floor.engine = "io_uring";
    floor.jobs = row.threads;
    floor.depth = std::max(1, static_cast<int>(std::ceil(blocks_of_read)));
  } else {
    floor.jobs = row.threads + (settings.io_threads < 0 ? 1 : settings.io_threads);
    floor.direct = false;
    make_cold({finest});
  }
  row.jobs = floor.jobs;
  row.depth = floor.depth;
  row.floors.push_back(run_for_figure(limit, [&] { return bytes_per_second(floor); }));
}

nlohmann::ordered_json print(const std::vector<Row>& rows, int reads) {
  fmt::print(
      "| backend | patches | threads | reads a second | blocks a read | MB/s | fio, jobs x depth | "
      "MB/s | of fio (min to max) | from the disk | p50, us | p99, us | p99.9, us |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  nlohmann::ordered_json report = nlohmann::ordered_json::array();
  for (const Row& row : rows) {
    const auto whole_reads = reads / row.threads * row.threads;
    const auto count = static_cast<double>(whole_reads);
    const auto rate = [](const Figures& of, double) { return of.block_bytes / of.seconds; };
    std::vector<double> ratios;
    for (std::size_t turn = 0; turn < row.figures.size(); ++turn)
      ratios.push_back(rate(row.figures[turn], 0) / row.floors[turn]);
    fmt::print(
        "| {} | {} | {} | {:.0f} | {:.2f} | {:.0f} | {} x {} | {:.0f} | {:.2f} ({:.2f} to {:.2f}) "
        "| {:.2f} | {:.0f} | {:.0f} | {:.0f} |\n",
        row.backend, row.distribution, row.threads,
        row.median_of([&](const Figures& of, double) { return count / of.seconds; }),
        row.median_of([&](const Figures& of, double) { return of.blocks / count; }),
        1e-6 * row.median_of(rate), row.jobs, row.depth, 1e-6 * median(row.floors), median(ratios),
        spread(ratios).smallest, spread(ratios).largest,
        row.median_of([](const Figures& of, double) { return of.disk_bytes / of.block_bytes; }),
        1e-3 * row.median_of([](const Figures& of, double) { return of.p50; }),
        1e-3 * row.median_of([](const Figures& of, double) { return of.p99; }),
        1e-3 * row.median_of([](const Figures& of, double) { return of.p999; }));
    nlohmann::ordered_json turns = nlohmann::ordered_json::array();
    for (std::size_t turn = 0; turn < row.figures.size(); ++turn) {
      const Figures& of = row.figures[turn];
      turns.push_back({{"seconds", of.seconds},
                       {"blocks", of.blocks},
                       {"block_bytes", of.block_bytes},
                       {"disk_bytes", of.disk_bytes},
                       {"p50_ns", of.p50},
                       {"p99_ns", of.p99},
                       {"p999_ns", of.p999},
                       {"floor_bytes_per_second", row.floors[turn]}});
    }
    report.push_back({{"backend", row.backend},
                      {"distribution", row.distribution},
                      {"threads", row.threads},
                      {"reads", count},
                      {"floor_jobs", row.jobs},
                      {"floor_depth", row.depth},
                      {"runs", turns}});
  }
  return report;
}

}  // namespace

int run_cold(const ColdSettings& settings) {
  const BaseMesh base = octahedron(settings.refinements);
  const fs::path path = fs::path(settings.directory) / "plait-bench.plait";
  std::uint64_t store_bytes = 0, block_bytes = 0;
  for (int level = 1; level <= settings.level; ++level) {
    const LevelGeometry geometry(base.slot_shapes(), BaseRelativeLevel(level),
                                 sizeof(Vector3<float>), settings.block_kibibytes << 10);
    store_bytes += geometry.total_bytes();
    block_bytes = geometry.max_block_bytes() / 4096 * 4096;
  }
  if (block_bytes == 0)
    throw Error(ErrorCode::kInvalidArgument,
                "--cold: expected blocks of at least a page of 4096 bytes, found smaller ones; "
                "give a larger --block");
  // The program itself needs memory, so a small store is read with less pressure.
  constexpr std::uint64_t kLeastLimitBytes = 48 << 20;
  const std::uint64_t limit_bytes = std::max(store_bytes / 4, kLeastLimitBytes);
  const std::uint64_t budget_bytes =
      settings.budget_mebibytes == 0 ? limit_bytes / 8 * 5 : settings.budget_mebibytes << 20;
  const MemoryLimit limit(limit_bytes);

  std::vector<Row> rows;
  for (const std::string& backend : settings.backends) {
    say_progress(fmt::format("{}: making a store", backend));
    make_store(path, base, settings, backend);
    const fs::path finest =
        Store::open(path, {}, default_backends()).level_file(0, settings.level).path;
    const std::size_t first = rows.size();
    for (const char* distribution : {"uniform", "zipf"})
      for (const int threads : settings.threads) rows.push_back({backend, distribution, threads});
    for (int turn = 0; turn < settings.runs; ++turn)
      for (std::size_t at = first; at < rows.size(); ++at) {
        say_progress(fmt::format("{}: run {} of {}", backend, turn + 1, settings.runs));
        measure(rows[at], path, finest, settings, limit, budget_bytes, block_bytes, turn);
      }
  }
  fs::remove_all(path);

  fmt::print(
      "{} patches of {} vertices, float32 positions: {:.0f} MiB in blocks of {} KiB; budget {:.0f} "
      "MiB, memory limit {}; {} reads, {} runs\nthe floor: random reads by {}\n\n",
      base.face_count(), patch_vertex_count(std::int64_t{1} << settings.level),
      static_cast<double>(store_bytes) / (1 << 20), block_bytes >> 10,
      static_cast<double>(budget_bytes) / (1 << 20),
      limit.limited() ? fmt::format("{:.0f} MiB", static_cast<double>(limit_bytes) / (1 << 20))
                      : "refused by this system",
      settings.reads, settings.runs,
      have_fio() ? "fio" : "threads of this program, because fio is not installed");
  write_json(settings.json, print(rows, settings.reads));
  return 0;
}

}  // namespace plait::bench
