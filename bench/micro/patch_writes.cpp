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
#include <tuple>
#include <vector>

#include "instrument/in_threads.h"
#include "micro/command_line.h"
#include "micro/support.h"
#include "plait/extend/pager.h"
#include "plait/extend/store_access.h"
#include "plait/extend/vertex_numbering.h"
#include "plait/patch_writer.h"
#include "plait/reader.h"
#include "plait/visit_vertices.h"

namespace {

using namespace plait;
using namespace plait::bench;
using Record = Vector3<float>;

void write_patches(Store& store, int level, int threads, const std::vector<Record>& records) {
  const std::uint64_t count = patch_vertex_count(std::int64_t{1} << level);
  const auto faces = static_cast<FaceId>(store.base().face_count());
  PatchWriter writer(store, {.attributes = {"record"}});
  std::atomic<FaceId> next = 0;
  instrument::in_threads(threads, [&](std::size_t) {
    for (FaceId face = next.fetch_add(1); face < faces; face = next.fetch_add(1))
      writer.write_patch<Record>("record", face, level,
                                 std::span(records).subspan(face * count, count));
  });
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

void run(const Settings& settings) {
  const BaseMesh base = octahedron(settings.refinements);
  const std::uint64_t vertices = counts_at_level(base, settings.level).vertices;
  const std::vector<Record> records(
      base.face_count() * patch_vertex_count(std::int64_t{1} << settings.level), Record{1, 2, 3});
  const double gigabytes = static_cast<double>(vertices * sizeof(Record)) * 1e-9;
  Measurements table("backend|#threads", {{"patch writer, GB/s", 2, true},
                                          {"sweep, GB/s", 2, true},
                                          {"patch writer / sweep", 2, true}});
  for (const std::string& backend : settings.backends) {
    // Each time a new store, so that no block is there before. Making the store is not measured.
    const auto rate_of = [&](const auto& write, int threads) {
      std::filesystem::remove_all(settings.store());
      StoreOptions options;
      options.backend = backend;
      options.budget_bytes = settings.budget_bytes();
      options.durability = Durability::kNone;
      Store store = Store::create(settings.store(), base, options, default_backends());
      store.add_attribute(schema_of<Record>("record"), settings.level);
      return gigabytes / seconds([&] { write(store, settings.level, threads, records); });
    };
    for (int turn = 0; turn < settings.runs; ++turn)
      for (const int threads : settings.threads) {
        say_progress(fmt::format("{}: run {} of {}", backend, turn + 1, settings.runs));
        const double writer = rate_of(write_patches, threads);
        const double swept = rate_of(sweep, threads);
        table.add({backend, fmt::format("{}", threads)}, {writer, swept, writer / swept});
      }
  }
  table.print(fmt::format("{} patches, {} vertices, float32 x 3, {} runs, budget {} MiB",
                          base.face_count(), vertices, settings.runs, settings.budget_mib));
}

}  // namespace

int main(int count, char** words) {
  return Program("plait_bench_patch_writes", "A patch writer beside a sweep",
                 {.backends = {"pread"}, .budget_mib = 16},
                 {"--refinements", "--level", "--backend", "--threads", "--budget", "--runs",
                  "--directory"})
      .run(count, words, run);
}
