// How long do threads wait for each other's locks, with more threads than processors too?
//
//   plait_bench_lock_waits [--threads 2,8,32] [--backend memory,pread,mmap,uring] [--level 5]
//                          [--refinements 5] [--reads 100000] [--first 3] [--last 6] [--runs 5]
//                          [--directory .]
//
// Reads: random patches of a store that is in memory, copied, by one Reader for all threads. Fused:
// Loop surfaces with normals, levels --first to --last, computed into memory that was touched
// before. Counted are the mutexes of the whole process from the first thread's start to the last
// one's end (micro/counted_locks.h), a read or a base face at a time. Without more waits for more
// threads, nothing keeps the threads of a larger machine from working at the same time but the
// memory. The program prints medians over the runs.
#include <fmt/format.h>

#include <string>
#include <vector>

#include "instrument/in_threads.h"
#include "instrument/random_faces.h"
#include "micro/command_line.h"
#include "micro/counted_locks.h"
#include "micro/recycled_memory.h"
#include "micro/support.h"
#include "plait/reader.h"

namespace {

using namespace plait;
using namespace plait::bench;
/// Adds what one piece of the work took; `do_work` does `pieces` pieces.
template <class Work>
void measure(Measurements& table, const std::string& name, int threads, double pieces,
             Work do_work) {
  take_lock_counts();
  const double ns = 1e9 * seconds(do_work);
  const LockCounts counts = take_lock_counts();
  const auto of_piece = [&](std::uint64_t count) { return static_cast<double>(count) / pieces; };
  table.add({name, fmt::format("{}", threads)},
            {ns / pieces, of_piece(counts.locked), of_piece(counts.contended),
             of_piece(counts.waited_ns), of_piece(counts.held_ns), of_piece(counts.slept_ns)});
}

Store store_for_reads(const Settings& settings, const LaidOutMesh& base,
                      const StoreOptions& options) {
  if (!default_backends().find(options.backend).traits.in_memory)
    return refined_store(settings.store(), base, settings.level, options);
  Store store = Store::create({}, base, options, default_backends());
  add_base_positions(store);
  subdivide(store, {.levels = settings.level});
  return store;
}

void read_patches(const std::string& backend, const LaidOutMesh& base, const Settings& settings,
                  Measurements& table) {
  StoreOptions options;
  options.backend = backend;
  options.budget_bytes = settings.budget_bytes();
  const Store store = store_for_reads(settings, base, options);
  const Reader reader(store);
  const std::uint64_t face_count = base.mesh.face_count();
  for (FaceId face = 0; face < face_count; ++face) reader.read_patch(face, settings.level);
  for (const int threads : settings.threads) {
    const int reads = settings.reads / threads * threads;
    const auto stride = static_cast<std::size_t>(threads);
    std::vector<std::vector<Vector3<float>>> into(
        stride, std::vector<Vector3<float>>(patch_vertex_count(std::int64_t{1} << settings.level)));
    for (int turn = 0; turn < settings.runs; ++turn) {
      say_progress(fmt::format("reads, {}, {} threads", backend, threads));
      const std::vector<FaceId> faces = instrument::draw_faces(
          false, face_count, static_cast<std::size_t>(reads), static_cast<std::uint64_t>(turn));
      measure(table, "reads, " + backend, threads, reads, [&] {
        instrument::in_threads(threads, [&](std::size_t thread) {
          for (std::size_t read = thread; read < faces.size(); read += stride)
            reader.read_patch(faces[read], settings.level)
                .attribute<Vector3<float>>("position")
                .copy_to(into[thread]);
        });
      });
    }
  }
}

void compute_levels(const LaidOutMesh& base, const Settings& settings, Measurements& table) {
  RecycledPages pages;
  const BackendRegistry backends = recycled_memory(pages);
  for (int level = settings.first; level <= settings.last; ++level)
    for (const int threads : settings.threads)
      for (int turn = -1; turn < settings.runs; ++turn) {  // the first one touches the memory
        say_progress(fmt::format("fused, level {}, {} threads", level, threads));
        Store store = recycled_store(base.mesh, backends);
        const SubdivideOptions how{
            .executor = ExecutorKind::kFused, .levels = level, .normals = true, .threads = threads};
        const auto work = [&] { subdivide(store, how); };
        turn < 0 ? work()
                 : measure(table, fmt::format("fused, level {}", level), threads,
                           static_cast<double>(base.mesh.face_count()), work);
      }
}

void run(const Settings& settings) {
  const LaidOutMesh base = mesh_or_octahedron({}, settings.refinements, LayoutKind::kHilbert);
  Measurements table("work|#threads", {{"ns", 0},
                                       {"locks", 4},
                                       {"of them waited for", 5},
                                       {"waited, ns", 1},
                                       {"held, ns", 1},
                                       {"slept, ns", 1}});
  for (const std::string& backend : settings.backends) read_patches(backend, base, settings, table);
  compute_levels(base, settings, table);
  table.print(
      fmt::format("Of one read (of {} in all) or one base face (of {}), all threads together; {} "
                  "runs",
                  settings.reads, base.mesh.face_count(), settings.runs));
}

}  // namespace

int main(int count, char** words) {
  return Program("plait_bench_lock_waits", "How long threads wait for locks",
                 {.backends = {"memory", "pread", "mmap", "uring"},
                  .threads = {2, 8, 32},
                  .reads = 100000},
                 {"--refinements", "--level", "--backend", "--threads", "--reads", "--first",
                  "--last", "--runs", "--directory"})
      .run(count, words, run);
}
