// How long does a program wait for a patch that is in memory, compared with a plain copy of as many
// bytes out of a mapped file? (Patches that come from a disk: plait bench run --workload
// patch-random.)
//
//   plait_bench_patch_reads [--level 5] [--refinements 5] [--backend pread,mmap] [--threads 1,2,8]
//                           [--budget MIB] [--reads 20000] [--runs 5] [--directory .]
//
// Each read pins the positions of one patch and copies them in row order. The patches are random:
// all are equally likely (uniform), or the n-th of them has a weight of 1/n (Zipf). The floor
// copies the bytes of a patch, which lie one after another there, out of a mapping that is in
// memory. All threads read by one Reader. With a budget that holds the whole store (0, the default)
// everything is read once before the time begins; with a smaller budget the blocks come from the
// page cache or the disk. The program prints a Markdown table of medians over the runs.
#include <fmt/format.h>
#include <sys/mman.h>

#include <boost/iostreams/device/mapped_file.hpp>
#include <cstring>
#include <string>
#include <vector>

#include "instrument/in_threads.h"
#include "instrument/random_faces.h"
#include "instrument/statistics.h"
#include "micro/command_line.h"
#include "micro/support.h"
#include "plait/extend/store_access.h"
#include "plait/reader.h"

namespace {

using namespace plait;
using namespace plait::bench;

/// A file that is in memory.
using Mapping = boost::iostreams::mapped_file_source;

/// Calls read(thread, face) for the faces of each thread, and returns nanoseconds of each call.
template <class Read>
std::vector<double> latencies(const std::vector<std::vector<FaceId>>& faces_of, Read read) {
  std::vector<std::vector<double>> times(faces_of.size());
  instrument::in_threads(static_cast<int>(faces_of.size()), [&](std::size_t thread) {
    for (const FaceId face : faces_of[thread])
      times[thread].push_back(1e9 * seconds([&] { read(thread, face); }));
  });
  std::vector<double> all;
  for (const std::vector<double>& of : times) all.insert(all.end(), of.begin(), of.end());
  return all;
}

void measure(Measurements& table, const std::string& backend, bool zipf, int threads,
             const Reader& reader, const Mapping& mapping, std::uint64_t face_count,
             const Settings& settings, unsigned seed) {
  const std::uint64_t vertices = patch_vertex_count(std::int64_t{1} << settings.level);
  const std::uint64_t patch_bytes = vertices * sizeof(Vector3<float>);
  const std::uint64_t places = mapping.size() / patch_bytes;
  const int reads_of_thread = settings.reads / threads;
  std::vector<std::vector<FaceId>> faces;
  faces.reserve(static_cast<std::size_t>(threads));
  for (int thread = 0; thread < threads; ++thread)
    faces.push_back(instrument::draw_faces(zipf, face_count,
                                           static_cast<std::size_t>(reads_of_thread),
                                           seed + static_cast<unsigned>(thread)));
  std::vector<std::vector<Vector3<float>>> into(faces.size(),
                                                std::vector<Vector3<float>>(vertices));
  std::vector<double> times;
  const double of_reads = seconds([&] {
    times = latencies(faces, [&](std::size_t thread, FaceId face) {
      reader.read_patch(face, settings.level)
          .attribute<Vector3<float>>("position")
          .copy_to(into[thread]);
    });
  });
  const double of_copies = seconds([&] {
    latencies(faces, [&](std::size_t thread, FaceId face) {
      std::memcpy(into[thread].data(), mapping.data() + face % places * patch_bytes, patch_bytes);
    });
  });
  const auto count = static_cast<double>(reads_of_thread) * threads;
  table.add({backend, zipf ? "zipf" : "uniform", fmt::format("{}", threads)},
            {count / of_reads, count / of_copies, of_reads / of_copies,
             instrument::quantile(times, 0.5), instrument::quantile(times, 0.99)});
}

void run(const Settings& settings) {
  const LaidOutMesh base = mesh_or_octahedron({}, settings.refinements, LayoutKind::kGiven);
  const std::uint64_t face_count = base.mesh.face_count();
  Measurements table("backend|patches|#threads", {{"reads a second", 0, true},
                                                  {"copies a second", 0},
                                                  {"time / copy"},
                                                  {"p50, ns", 0},
                                                  {"p99, ns", 0}});
  for (const std::string& backend : settings.backends) {
    say_progress(fmt::format("{}: making a store", backend));
    StoreOptions options;
    options.backend = backend;
    options.budget_bytes = settings.budget_bytes();
    const Store store = refined_store(settings.store(), base, settings.level, options);
    const Reader reader(store);
    const Mapping mapping(StoreAccess::level_file(store, 0, settings.level).path.native());
#ifdef MADV_POPULATE_READ  // Linux 5.14
    ::madvise(const_cast<char*>(mapping.data()), mapping.size(), MADV_POPULATE_READ);
#endif
    for (FaceId face = 0; face < face_count; ++face) reader.read_patch(face, settings.level);
    for (int turn = 0; turn < settings.runs; ++turn)
      for (const bool zipf : {false, true})
        for (const int threads : settings.threads) {
          say_progress(fmt::format("{}: run {} of {}", backend, turn + 1, settings.runs));
          measure(table, backend, zipf, threads, reader, mapping, face_count, settings,
                  static_cast<unsigned>(100 * turn));
        }
  }
  table.print(
      fmt::format("{} patches of {} vertices, float32 positions, {} reads, {} runs, budget "
                  "{} MiB (0: for everything)",
                  face_count, patch_vertex_count(std::int64_t{1} << settings.level), settings.reads,
                  settings.runs, settings.budget_mib));
}

}  // namespace

int main(int count, char** words) {
  return Program("plait_bench_patch_reads", "Reads of random patches",
                 {.backends = {"pread", "mmap"}, .threads = {1, 2, 8}},
                 {"--refinements", "--level", "--backend", "--threads", "--budget", "--reads",
                  "--runs", "--directory"})
      .run(count, words, run);
}
