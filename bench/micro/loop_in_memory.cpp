// How fast is a Loop surface computed into memory, compared with copying as many bytes?
//
//   plait_bench_loop_in_memory [--mesh FILE] [--first 3] [--last 6] [--runs 5] [--threads 1,2]
//
// Without --mesh it takes an octahedron, refined in memory to 8192 faces. It measures every level,
// positions alone and with normals, on each number of threads: the time from a base mesh in its
// layout to finished levels in memory that was touched before. Right after each run it measures the
// floor: memcpy of as many bytes on as many threads. The first run does not count.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <string>

#include "instrument/in_threads.h"
#include "micro/command_line.h"
#include "micro/recycled_memory.h"
#include "micro/support.h"
#include "plait/digest.h"
#include "plait/store.h"

namespace {

using namespace plait;
using namespace plait::bench;

/// The seconds of copying `bytes` bytes into memory that was touched before.
double copy_seconds(RecycledPages& pages, std::uint64_t bytes, int threads) {
  constexpr std::uint64_t kSource = 64 << 20;  // larger than most caches
  std::byte* const to = pages.take(bytes);
  std::byte* const from = pages.take(kSource);
  const std::uint64_t share = bytes / static_cast<std::uint64_t>(threads) / 64 * 64;
  const double result = seconds([&] {
    instrument::in_threads(threads, [&](std::size_t thread) {
      for (std::uint64_t done = 0; done < share; done += kSource)
        std::memcpy(to + thread * share + done, from, std::min(kSource, share - done));
    });
  });
  pages.give_back(to, bytes);
  pages.give_back(from, kSource);
  return result;
}

void run(const Settings& settings) {
  const LaidOutMesh base = mesh_or_octahedron(settings.mesh, 5, LayoutKind::kHilbert);
  RecycledPages pages;
  const BackendRegistry backends = recycled_memory(pages);
  Measurements table("#level|#vertices|attributes|#threads|digest",
                     {{"ns a vertex", 2, true}, {"memcpy"}, {"over memcpy"}});
  for (int level = settings.first; level <= settings.last; ++level)
    for (const bool normals : {false, true})
      for (const int threads : settings.threads) {
        const std::uint64_t vertices = counts_at_level(base.mesh, level).vertices;
        const double scale = 1e9 / static_cast<double>(vertices);
        const SubdivideOptions how{.executor = ExecutorKind::kFused,
                                   .levels = level,
                                   .normals = normals,
                                   .threads = threads};
        std::string digest_text;
        for (int turn = -1; turn < settings.runs; ++turn) {  // the first one does not count
          say_progress(fmt::format("level {}, {} threads{}", level, threads,
                                   normals ? ", with normals" : ""));
          double time = 0;
          {
            Store store = recycled_store(base.mesh, backends);
            time = seconds([&] { subdivide(store, how); });
            if (turn < 0) digest_text = digest(store).to_string();
          }
          const double copy = copy_seconds(pages, vertices * (normals ? 24 : 12), threads);
          if (turn >= 0)
            table.add({fmt::format("{}", level), fmt::format("{}", vertices),
                       normals ? "position, normal" : "position", fmt::format("{}", threads),
                       digest_text},
                      {scale * time, scale * copy, time / copy});
        }
      }
  table.print(fmt::format("{} base vertices, fused executor, layout hilbert, {} runs",
                          base.mesh.vertex_count(), settings.runs));
}

}  // namespace

int main(int count, char** words) {
  return Program("plait_bench_loop_in_memory",
                 "Loop surfaces in memory, compared with copying as many bytes", {},
                 {"--mesh", "--first", "--last", "--runs", "--threads"})
      .run(count, words, run);
}
