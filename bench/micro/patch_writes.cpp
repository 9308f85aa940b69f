// How fast does a PatchWriter fill all levels from arrays in memory, compared with a sweep that
// copies as many bytes to the same levels?
//
//   plait_bench_patch_writes [--level 5] [--refinements 6] [--backend recycled,pread]
//                            [--threads 1,2] [--runs 5] [--directory .] [--json FILE]
//
// The faces come in layout order. The array of the writer has a patch in row order for each face,
// so vertices on edges are there twice; that of the sweep has the slots one after another: its rate
// is the floor. "recycled" are levels in memory that was touched before. The stores are made with
// durability `none`: the operating system decides when the bytes go to the disk. The program prints
// a Markdown table of medians over the runs, which take turns.
#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "micro/command_line.h"
#include "micro/recycled_memory.h"
#include "micro/support.h"
#include "plait/extend/sweep.h"
#include "plait/patch_writer.h"
#include "plait/reader.h"
#include "plait/registry.h"

namespace {

using namespace plait;
using namespace plait::bench;
namespace fs = std::filesystem;
using Point = Vector3<float>;

struct Settings {
  int level = 5, refinements = 6, runs = 5;
  std::vector<int> threads = {1, 2};
  std::vector<std::string> backends = {"recycled", "pread"};
  std::string directory = ".", json;
};

struct Row {
  std::string backend;
  int threads;
  std::vector<double> writer = {}, sweep = {};  ///< seconds
};

Store make_store(const Row& row, const BaseMesh& base, int level, const fs::path& path,
                 const BackendRegistry& recycled) {
  const bool in_memory = row.backend == "recycled";
  StoreOptions options;
  options.backend = row.backend;
  options.durability = Durability::kNone;
  fs::remove_all(path);
  Store store = Store::create(in_memory ? fs::path() : path, base, options,
                              in_memory ? recycled : default_backends());
  store.add_attribute(schema_of<Point>("position"), level);
  return store;
}

void sweep_from(Store& store, const std::vector<Point>& records, int level, int threads) {
  // Any address in the array will do: the copy is what counts.
  const std::size_t mask = std::bit_floor(records.size() / 2) - 1;
  SweepPass pass{"copy", {{0, 1, level, Access::kOverwrite}}, {}};
  pass.kernel = [&](const SweepView& view, EdgeId edge, int) {
    for (int each = 1; each <= level; ++each) {
      const std::span<Point> slot = view.records<Point>(0, each, edge);
      std::memcpy(slot.data(), &records[edge * slot.size() & mask], slot.size_bytes());
    }
  };
  sweep(store, pass, {.threads = threads});
}

void write_from(Store& store, const std::vector<Point>& records, int level, int threads) {
  const std::uint64_t vertices = patch_vertex_count(std::int64_t{1} << level);
  PatchWriter writer(store);
  tbb::task_arena arena(threads);
  arena.execute([&] {
    tbb::parallel_for(tbb::blocked_range<FaceId>(0, static_cast<FaceId>(store.base().face_count())),
                      [&](const tbb::blocked_range<FaceId>& faces) {
                        for (FaceId face = faces.begin(); face < faces.end(); ++face)
                          writer.write_patch<Point>(
                              "position", face, level,
                              std::span(records).subspan(face * vertices, vertices));
                      });
  });
  writer.finish();
}

int run(const Settings& settings) {
  const BaseMesh base = octahedron(settings.refinements);
  const fs::path path = fs::path(settings.directory) / "plait-bench.plait";
  RecycledPages pages;
  const BackendRegistry recycled = recycled_memory(pages);
  const std::vector<Point> records(
      base.face_count() * patch_vertex_count(std::int64_t{1} << settings.level), Point{1, 2, 3});
  std::vector<Row> rows;
  for (const std::string& backend : settings.backends)
    for (const int threads : settings.threads) rows.push_back({backend, threads});
  for (int turn = -1; turn < settings.runs; ++turn)  // the first turn touches memory and files
    for (Row& row : rows) {
      say_progress(fmt::format("{}: run {} of {}", row.backend, turn + 1, settings.runs));
      for (const bool writes : {false, true}) {
        Store store = make_store(row, base, settings.level, path, recycled);
        const double time = seconds([&] {
          writes ? write_from(store, records, settings.level, row.threads)
                 : sweep_from(store, records, settings.level, row.threads);
          store.commit();
        });
        if (turn >= 0) (writes ? row.writer : row.sweep).push_back(time);
      }
    }
  fs::remove_all(path);

  const double gigabytes =
      1e-9 * static_cast<double>(sizeof(Point)) *
      static_cast<double>(counts_at_level(base, settings.level).vertices - base.vertex_count());
  fmt::print("{} faces to level {}, float32 positions, {:.2f} GB, {} runs\n\n", base.face_count(),
             settings.level, gigabytes, settings.runs);
  fmt::print(
      "| backend | threads | patch writer, GB/s (min to max) | sweep, GB/s | writer / sweep "
      "|\n|---|---|---|---|---|\n");
  nlohmann::json report = nlohmann::json::array();
  for (const Row& row : rows) {
    const double writer = median(row.writer), floor = median(row.sweep);
    const Spread range = spread(row.writer);
    fmt::print("| {} | {} | {:.2f} ({:.2f} to {:.2f}) | {:.2f} | {:.2f} |\n", row.backend,
               row.threads, gigabytes / writer, gigabytes / range.largest,
               gigabytes / range.smallest, gigabytes / floor, floor / writer);
    report.push_back({{"backend", row.backend},
                      {"threads", row.threads},
                      {"gigabytes", gigabytes},
                      {"writer_seconds", row.writer},
                      {"sweep_seconds", row.sweep}});
  }
  write_json(settings.json, report);
  return 0;
}

}  // namespace

int main(int count, char** words) {
  Settings settings;
  return run_program(
      "plait_bench_patch_writes", "Patches from arrays in memory", count, words,
      [&](CommandLine& app) {
        add_number_option(app, "--level", settings.level, 1, 10, "The finest level");
        add_number_option(app, "--refinements", settings.refinements, 0, 9,
                          "Refinements of the octahedron that give the base mesh");
        app.add_option("--backend", settings.backends, "Backends, several with commas")
            ->delimiter(',');
        app.add_option("--threads", settings.threads, "Numbers of threads, several with commas")
            ->delimiter(',')
            ->range(1, 64);
        add_runs_option(app, settings.runs);
        add_directory_option(app, settings.directory);
        add_json_option(app, settings.json);
      },
      [&] { return run(settings); }, &settings.directory);
}
