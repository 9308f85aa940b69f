// How fast is a Loop surface computed into memory, compared with copying and filling as many bytes?
//
//   plait_bench_loop_in_memory [--mesh FILE] [--first 3] [--last 6] [--runs 5] [--threads 2]
//
// Without --mesh it takes an octahedron, refined in memory to 8192 faces. It measures every level,
// positions alone and with normals, on one thread and on --threads: the time from a base mesh in
// its layout to finished levels in memory that was touched before. Right after each run it measures
// the floors: memcpy and a non-temporal fill of as many bytes on as many threads. The first run
// does not count.
#include <fmt/format.h>

#if defined(__SSE2__)
#include <immintrin.h>
#endif

#include <cstring>
#include <string>
#include <thread>
#include <vector>

#include "micro/command_line.h"
#include "micro/recycled_memory.h"
#include "micro/support.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/layout.h"
#include "plait/mesh_io.h"
#include "plait/store.h"
#include "plait/subdivide.h"

namespace {

using namespace plait;
using namespace plait::bench;

struct Settings {
  std::string mesh;
  int first = 3, last = 6, runs = 5, threads = 2;
};

/// Runs work(offset, bytes) on every thread, each with its share of [0, bytes). Returns the
/// seconds.
template <class Work>
double on_threads(int threads, std::uint64_t bytes, Work work) {
  return seconds([&] {
    std::vector<std::jthread> helpers;
    const std::uint64_t share = bytes / static_cast<std::uint64_t>(threads) / 64 * 64;
    for (int i = 1; i < threads; ++i)
      helpers.emplace_back([&, i] { work(static_cast<std::uint64_t>(i) * share, share); });
    work(0, share);
  });
}

void fill(std::byte* to, std::uint64_t bytes) {
#if defined(__SSE2__)
  const __m128 value = _mm_set1_ps(1);
  for (std::uint64_t at = 0; at < bytes; at += 16)
    _mm_stream_ps(reinterpret_cast<float*>(to + at), value);
  _mm_sfence();
#else
  std::memset(to, 1, bytes);
#endif
}

struct Case {
  int level, threads;
  bool normals;
  std::uint64_t vertices = 0, bytes = 0;
  std::vector<double> plait = {}, copy = {}, stream = {};
  std::string digest = {};
};

void run_case(Case& at, const LaidOutMesh& base, RecycledPages& pages,
              const BackendRegistry& backends, bool check) {
  StoreOptions options;
  options.backend = "recycled";
  options.budget_bytes = std::uint64_t{1} << 40;  // nothing is ever evicted
  SubdivideOptions how;
  how.executor = ExecutorKind::kFused;
  how.levels = at.level;
  how.normals = at.normals;
  how.threads = at.threads;
  {
    Store store = Store::create({}, base.mesh, options, backends);
    add_base_positions(store);
    at.plait.push_back(seconds([&] { subdivide(store, how); }));
    if (check) at.digest = digest(store).to_string();
  }
  at.vertices = counts_at_level(base.mesh, at.level).vertices;
  at.bytes = at.vertices * (at.normals ? 24 : 12);
  std::byte* to = pages.take(at.bytes);
  std::byte* from = pages.take(64 << 20);
  at.copy.push_back(on_threads(at.threads, at.bytes, [&](std::uint64_t first, std::uint64_t count) {
    for (std::uint64_t done = 0; done < count; done += 64 << 20)
      std::memcpy(to + first + done, from, std::min<std::uint64_t>(64 << 20, count - done));
  }));
  at.stream.push_back(
      on_threads(at.threads, at.bytes,
                 [&](std::uint64_t first, std::uint64_t count) { fill(to + first, count); }));
  pages.give_back(to, at.bytes);
  pages.give_back(from, 64 << 20);
}

int run(const Settings& settings) {
  const LaidOutMesh base = lay_out(
      settings.mesh.empty() ? octahedron(5) : read_base_mesh(settings.mesh), LayoutKind::kHilbert);
  RecycledPages pages;
  const BackendRegistry backends = recycled_memory(pages);
  instrument::Table table = instrument::table_with(
      "#level|#vertices|attributes|#threads|#ns a vertex|#memcpy|#non-temporal fill|#over "
      "memcpy|digest");
  for (int level = settings.first; level <= settings.last; ++level)
    for (const bool normals : {false, true})
      for (int threads = 1; threads <= settings.threads; ++threads) {
        Case at{level, threads, normals};
        say_progress(
            fmt::format("level {}, {} threads{}", level, threads, normals ? ", with normals" : ""));
        run_case(at, base, pages, backends, true);
        at.plait.clear(), at.copy.clear(), at.stream.clear();
        for (int turn = 0; turn < settings.runs; ++turn) run_case(at, base, pages, backends, false);
        const double scale = 1e9 / static_cast<double>(at.vertices);
        table.rows.push_back(
            {{number(level, 0), number(static_cast<double>(at.vertices), 0),
              normals ? "position, normal" : "position", number(threads, 0),
              spread(at.plait, scale), middle(at.copy, scale), middle(at.stream, scale),
              number(*middle(at.plait).value / *middle(at.copy).value), at.digest}});
      }
  print_table(fmt::format("{} base vertices, fused executor, layout hilbert, {} runs",
                          base.mesh.vertex_count(), settings.runs),
              table);
  return 0;
}

}  // namespace

int main(int count, char** words) {
  Settings settings;
  return run_program(
      "plait_bench_loop_in_memory", "Loop surfaces in memory, compared with copying as many bytes",
      count, words,
      [&](CommandLine& app) {
        add_mesh_option(app, settings.mesh, "an octahedron refined to 8,192 faces");
        add_number_option(app, "--first", settings.first, 1, 12, "The first level measured");
        add_number_option(app, "--last", settings.last, 1, 12, "The last level measured");
        add_runs_option(app, settings.runs);
        add_number_option(app, "--threads", settings.threads, 1, 64,
                          "The largest number of threads; measures from one thread up");
      },
      [&] { return run(settings); });
}
