// How fast does a patch writer fill all levels from arrays in memory, compared with a sweep that
// writes the same vertices?
//
//   plait_bench_patch_writes [--level 5] [--refinements 5] [--backend pread] [--threads 1,2]
//                            [--budget MIB] [--runs 5] [--directory .]
//
// Each measurement fills a new store. The patch writer gets the patches in layout order, each with
// the vertices of all levels. The floor is visit_vertices(), which copies the records of each slot
// out of an array. Both times end when all blocks are handed to the backend; syncing is not in
// them. A turn runs both, and ratios are computed within a turn. The program prints a Markdown
// table of medians over the runs.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <span>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

#include "micro/command_line.h"
#include "micro/support.h"
#include "plait/extend/pager.h"
#include "plait/extend/store_access.h"
#include "plait/extend/vertex_numbering.h"
#include "plait/patch_writer.h"
#include "plait/reader.h"
#include "plait/registry.h"
#include "plait/store.h"
#include "plait/visit_vertices.h"

namespace {

using namespace plait;
using namespace plait::bench;
namespace fs = std::filesystem;
using Record = Vector3<float>;

struct Settings {
  int level = 5, refinements = 5, runs = 5;
  std::vector<int> threads = {1, 2};
  std::vector<std::string> backends = {"pread"};
  std::uint64_t budget_mebibytes = 16;
  std::string directory = ".";
};

struct Row {
  std::string backend;
  int threads;
  std::vector<double> writer = {}, sweep = {}, share = {};  ///< GB/s; writer / sweep
};

void write_patches(Store& store, int level, int threads, const std::vector<Record>& records) {
  const std::uint64_t count = patch_vertex_count(std::int64_t{1} << level);
  const auto faces = static_cast<FaceId>(store.base().face_count());
  PatchWriter writer(store, {.attributes = {"record"}});
  std::atomic<FaceId> next = 0;
  const auto work = [&] {
    for (FaceId face = next.fetch_add(1); face < faces; face = next.fetch_add(1))
      writer.write_patch<Record>("record", face, level,
                                 std::span(records).subspan(face * count, count));
  };
  {
    std::vector<std::jthread> helpers;
    for (int i = 1; i < threads; ++i) helpers.emplace_back(work);
    work();
  }
  writer.finish();
  StoreAccess::pager(store).flush();
}

void sweep(Store& store, int level, int threads, const std::vector<Record>& records) {
  const VertexNumbering numbering(store.base().topology(), level);
  visit_vertices(
      store, {.name = "copy", .threads = threads}, std::tuple{overwrites<Record>("record")},
      [&](const VertexRun& run, std::span<Record> to) {
        const auto first = numbering.first_of(run.level) + run.first;
        std::copy_n(records.begin() + static_cast<std::ptrdiff_t>(first), run.count, to.begin());
      });
  StoreAccess::pager(store).flush();
}

int run(const Settings& settings) {
  const BaseMesh base = octahedron(settings.refinements);
  const fs::path path = fs::path(settings.directory) / "plait-bench.plait";
  const std::uint64_t vertices = counts_at_level(base, settings.level).vertices;
  const std::vector<Record> records(
      base.face_count() * patch_vertex_count(std::int64_t{1} << settings.level), Record{1, 2, 3});
  const double gigabytes = static_cast<double>(vertices * sizeof(Record)) * 1e-9;
  std::vector<Row> rows;
  for (const std::string& backend : settings.backends) {
    // Each time a new store, so that no block is there before. Making the store is not measured.
    const auto rate_of = [&](const auto& write, int threads) {
      fs::remove_all(path);
      StoreOptions options;
      options.backend = backend;
      options.budget_bytes = settings.budget_mebibytes << 20;
      options.durability = Durability::kNone;
      Store store = Store::create(path, base, options, default_backends());
      store.add_attribute(schema_of<Record>("record"), settings.level);
      return gigabytes / seconds([&] { write(store, settings.level, threads, records); });
    };
    const std::size_t first = rows.size();
    for (const int threads : settings.threads) rows.push_back({backend, threads});
    for (int turn = 0; turn < settings.runs; ++turn)
      for (std::size_t at = first; at < rows.size(); ++at) {
        Row& row = rows[at];
        say_progress(fmt::format("{}: run {} of {}", backend, turn + 1, settings.runs));
        row.writer.push_back(rate_of(write_patches, row.threads));
        row.sweep.push_back(rate_of(sweep, row.threads));
        row.share.push_back(row.writer.back() / row.sweep.back());
      }
  }
  fs::remove_all(path);
  instrument::Table table = instrument::table_with(
      "backend|#threads|#patch writer, GB/s|#sweep, GB/s|#patch writer / sweep");
  for (const Row& row : rows)
    table.rows.push_back({{row.backend, number(row.threads, 0), spread(row.writer),
                           spread(row.sweep), spread(row.share)}});
  print_table(fmt::format("{} patches, {} vertices, float32 x 3, {} runs, budget {} MiB",
                          base.face_count(), vertices, settings.runs, settings.budget_mebibytes),
              table);
  return 0;
}

}  // namespace

int main(int count, char** words) {
  Settings settings;
  return run_program(
      "plait_bench_patch_writes", "A patch writer beside a sweep", count, words,
      [&](CommandLine& app) {
        add_surface_options(app, settings.refinements, settings.level);
        add_backends_option(app, settings.backends);
        add_threads_option(app, settings.threads);
        app.add_option("--budget", settings.budget_mebibytes, "Budget for blocks in memory, MiB")
            ->range(1, 1 << 20);
        add_runs_option(app, settings.runs);
        add_directory_option(app, settings.directory);
      },
      [&] { return run(settings); }, &settings.directory);
}
