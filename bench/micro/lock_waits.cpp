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

#include <cstring>
#include <filesystem>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "instrument/random_faces.h"
#include "micro/command_line.h"
#include "micro/counted_locks.h"
#include "micro/recycled_memory.h"
#include "micro/support.h"
#include "plait/layout.h"
#include "plait/reader.h"
#include "plait/registry.h"

namespace {

using namespace plait;
using namespace plait::bench;
namespace fs = std::filesystem;

struct Settings {
  int level = 5, refinements = 5, reads = 100000, first = 3, last = 6, runs = 5;
  std::vector<int> threads = {2, 8, 32};
  std::vector<std::string> backends = {"memory", "pread", "mmap", "uring"};
  std::string directory = ".";
};

/// One kind of work with one number of threads. Figures are of one piece of it.
struct Case {
  std::string work;
  int threads;
  std::vector<double> ns = {}, locked = {}, contended = {}, waited = {}, held = {}, slept = {};

  /// `do_work` does `pieces` pieces.
  template <class Work>
  void measure(double pieces, Work do_work) {
    take_lock_counts();
    ns.push_back(1e9 * seconds(do_work) / pieces);
    const LockCounts counts = take_lock_counts();
    const auto add = [&](std::vector<double>& to, std::uint64_t count) {
      to.push_back(static_cast<double>(count) / pieces);
    };
    add(locked, counts.locked);
    add(contended, counts.contended);
    add(waited, counts.waited_ns);
    add(held, counts.held_ns);
    add(slept, counts.slept_ns);
  }
};

void read_patches(const std::string& backend, const BaseMesh& base, const Settings& settings,
                  std::vector<Case>& cases) {
  StoreOptions options;
  options.backend = backend;
  options.budget_bytes = std::uint64_t{1} << 34;
  const bool in_memory = default_backends().find(backend).traits.in_memory;
  const fs::path path = fs::path(settings.directory) / "plait-bench.plait";
  const auto make = [&] {
    Store store = Store::create(in_memory ? "" : path, base, options, default_backends());
    add_base_positions(store);
    subdivide(store, {.levels = settings.level});
    if (!in_memory) store.commit();
    return store;
  };
  const auto made = [&] {
    Store store = make();
    if (in_memory) return store;
    store.close();
    OpenOptions open;
    open.budget_bytes = options.budget_bytes;
    return Store::open(path, open, default_backends());
  };
  {
    const Store store = made();
    const Reader reader(store);
    for (FaceId face = 0; face < base.face_count(); ++face) reader.read_patch(face, settings.level);
    for (const int threads : settings.threads) {
      Case at{fmt::format("reads, {}", backend), threads};
      const int reads = settings.reads / threads * threads;
      const std::uint64_t vertices = patch_vertex_count(std::int64_t{1} << settings.level);
      std::vector<std::vector<Vector3<float>>> into(static_cast<std::size_t>(threads),
                                                    std::vector<Vector3<float>>(vertices));
      for (int turn = 0; turn < settings.runs; ++turn) {
        say_progress(fmt::format("reads, {}, {} threads", backend, threads));
        const std::vector<FaceId> faces =
            instrument::draw_faces(false, base.face_count(), static_cast<std::size_t>(reads),
                                   static_cast<std::uint64_t>(turn));
        at.measure(reads, [&] {
          std::vector<std::jthread> readers;
          readers.reserve(static_cast<std::size_t>(threads));
          for (int thread = 0; thread < threads; ++thread)
            readers.emplace_back([&, thread] {
              for (std::size_t read = static_cast<std::size_t>(thread); read < faces.size();
                   read += static_cast<std::size_t>(threads))
                reader.read_patch(faces[read], settings.level)
                    .attribute<Vector3<float>>("position")
                    .copy_to(into[static_cast<std::size_t>(thread)]);
            });
        });
      }
      cases.push_back(std::move(at));
    }
  }
  fs::remove_all(path);
}

void compute_levels(const LaidOutMesh& base, const Settings& settings, std::vector<Case>& cases) {
  RecycledPages pages;
  const BackendRegistry backends = recycled_memory(pages);
  StoreOptions options;
  options.backend = "recycled";
  options.budget_bytes = std::uint64_t{1} << 40;
  for (int level = settings.first; level <= settings.last; ++level)
    for (const int threads : settings.threads) {
      Case at{fmt::format("fused, level {}", level), threads};
      for (int turn = -1; turn < settings.runs; ++turn) {  // the first one touches the memory
        say_progress(fmt::format("fused, level {}, {} threads", level, threads));
        Store store = Store::create({}, base.mesh, options, backends);
        add_base_positions(store);
        const SubdivideOptions how{
            .executor = ExecutorKind::kFused, .levels = level, .normals = true, .threads = threads};
        const auto work = [&] { subdivide(store, how); };
        turn < 0 ? work() : at.measure(static_cast<double>(base.mesh.face_count()), work);
      }
      cases.push_back(std::move(at));
    }
}

int run(const Settings& settings) {
  const LaidOutMesh base = lay_out(octahedron(settings.refinements), LayoutKind::kHilbert);
  std::vector<Case> cases;
  for (const std::string& backend : settings.backends)
    read_patches(backend, base.mesh, settings, cases);
  compute_levels(base, settings, cases);
  instrument::Table table = instrument::table_with(
      "work|#threads|#ns|#locks|#of them waited for|#waited, ns|#held, ns|#slept, ns");
  for (const Case& at : cases)
    table.rows.push_back(
        {{at.work, number(at.threads, 0), middle(at.ns, 1, 0), middle(at.locked, 1, 4),
          middle(at.contended, 1, 5), middle(at.waited, 1, 1), middle(at.held, 1, 1),
          middle(at.slept, 1, 1)}});
  print_table(
      fmt::format("Of one read (of {} in all) or one base face (of {}), all threads together; {} "
                  "runs",
                  settings.reads, base.mesh.face_count(), settings.runs),
      table);
  return 0;
}

}  // namespace

int main(int count, char** words) {
  Settings settings;
  return run_program(
      "plait_bench_lock_waits", "How long threads wait for locks", count, words,
      [&](CommandLine& app) {
        add_surface_options(app, settings.refinements, settings.level);
        add_backends_option(app, settings.backends);
        add_threads_option(app, settings.threads);
        add_number_option(app, "--reads", settings.reads, 64, 100000000, "Reads of all threads");
        add_number_option(app, "--first", settings.first, 1, 12, "The first level computed");
        add_number_option(app, "--last", settings.last, 1, 12, "The last level computed");
        add_runs_option(app, settings.runs);
        add_directory_option(app, settings.directory);
      },
      [&] { return run(settings); }, &settings.directory);
}
