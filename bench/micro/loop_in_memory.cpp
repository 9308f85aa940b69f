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

#include "instrument/in_threads.h"
#include "micro/command_line.h"
#include "micro/recycled_memory.h"
#include "micro/support.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/layout.h"
#include "plait/mesh_io.h"
#include "plait/store.h"

namespace {

using namespace plait;
using namespace plait::bench;

struct Settings {
  std::string mesh;
  int first = 3, last = 6, runs = 5, threads = 2;
};

/// The seconds of work(offset, bytes) on every thread, each with its share of [0, bytes).
template <class Work>
double on_threads(int threads, std::uint64_t bytes, Work work) {
  const std::uint64_t share = bytes / static_cast<std::uint64_t>(threads) / 64 * 64;
  return seconds([&] {
    instrument::in_threads(threads, [&](std::size_t thread) { work(thread * share, share); });
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
};
struct Times {
  double plait, copy, stream;
};

/// `digest_of` gets the digest of the surface, unless it is nullptr.
Times run_case(const Case& at, const LaidOutMesh& base, RecycledPages& pages,
               const BackendRegistry& backends, std::string* digest_of) {
  Times times{};
  {
    StoreOptions options;
    options.backend = "recycled";
    options.budget_bytes = std::uint64_t{1} << 40;  // nothing is ever evicted
    Store store = Store::create({}, base.mesh, options, backends);
    add_base_positions(store);
    const SubdivideOptions how{.executor = ExecutorKind::kFused,
                               .levels = at.level,
                               .normals = at.normals,
                               .threads = at.threads};
    times.plait = seconds([&] { subdivide(store, how); });
    if (digest_of != nullptr) *digest_of = digest(store).to_string();
  }
  const std::uint64_t bytes =
      counts_at_level(base.mesh, at.level).vertices * (at.normals ? 24 : 12);
  std::byte* to = pages.take(bytes);
  std::byte* from = pages.take(64 << 20);
  times.copy = on_threads(at.threads, bytes, [&](std::uint64_t first, std::uint64_t count) {
    for (std::uint64_t done = 0; done < count; done += 64 << 20)
      std::memcpy(to + first + done, from, std::min<std::uint64_t>(64 << 20, count - done));
  });
  times.stream = on_threads(at.threads, bytes, [&](std::uint64_t first, std::uint64_t count) {
    fill(to + first, count);
  });
  pages.give_back(to, bytes);
  pages.give_back(from, 64 << 20);
  return times;
}

int run(const Settings& settings) {
  const LaidOutMesh base = lay_out(
      settings.mesh.empty() ? octahedron(5) : read_base_mesh(settings.mesh), LayoutKind::kHilbert);
  RecycledPages pages;
  const BackendRegistry backends = recycled_memory(pages);
  Measurements table(
      "#level|#vertices|attributes|#threads|digest",
      {{"ns a vertex", 2, true}, {"memcpy"}, {"non-temporal fill"}, {"over memcpy"}});
  for (int level = settings.first; level <= settings.last; ++level)
    for (const bool normals : {false, true})
      for (int threads = 1; threads <= settings.threads; ++threads) {
        const std::uint64_t vertices = counts_at_level(base.mesh, level).vertices;
        const double scale = 1e9 / static_cast<double>(vertices);
        say_progress(
            fmt::format("level {}, {} threads{}", level, threads, normals ? ", with normals" : ""));
        std::string digest;
        run_case({level, threads, normals}, base, pages, backends, &digest);
        for (int turn = 0; turn < settings.runs; ++turn) {
          const Times of = run_case({level, threads, normals}, base, pages, backends, nullptr);
          table.add({fmt::format("{}", level), fmt::format("{}", vertices),
                     normals ? "position, normal" : "position", fmt::format("{}", threads), digest},
                    {scale * of.plait, scale * of.copy, scale * of.stream, of.plait / of.copy});
        }
      }
  table.print(fmt::format("{} base vertices, fused executor, layout hilbert, {} runs",
                          base.mesh.vertex_count(), settings.runs));
  return 0;
}

}  // namespace

int main(int count, char** words) {
  Settings settings;
  Program program("plait_bench_loop_in_memory",
                  "Loop surfaces in memory, compared with copying as many bytes");
  program.mesh(settings.mesh, "an octahedron refined to 8,192 faces")
      .levels(settings.first, settings.last)
      .runs(settings.runs)
      .number("--threads", settings.threads, 1, 64,
              "The largest number of threads; measures from one thread up");
  return program.run(count, words, [&] { return run(settings); });
}
