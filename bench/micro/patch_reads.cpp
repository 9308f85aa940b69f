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

#include <cstring>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "instrument/random_faces.h"
#include "instrument/statistics.h"
#include "micro/command_line.h"
#include "micro/support.h"
#include "plait/extend/file.h"
#include "plait/extend/store_access.h"
#include "plait/reader.h"
#include "plait/registry.h"

namespace {

using namespace plait;
using namespace plait::bench;
namespace fs = std::filesystem;

struct Settings {
  int level = 5, refinements = 5, runs = 5, reads = 20000;
  std::vector<int> threads = {1, 2, 8};
  std::vector<std::string> backends = {"pread", "mmap"};
  std::uint64_t budget_mebibytes = 0, block_kibibytes = StoreOptions().block_bytes >> 10;
  std::string directory = ".";
};

struct Row {
  std::string backend, distribution;
  int threads;
  std::vector<double> reads_per_second = {}, floor_reads_per_second = {}, p50 = {}, p99 = {},
                      p999 = {};
};

class Mapping {
 public:
  explicit Mapping(const fs::path& path) : file_(path, OpenMode::kRead), bytes_(file_.size()) {
    void* const mapped =
        ::mmap(nullptr, bytes_, PROT_READ, MAP_SHARED | MAP_POPULATE, file_.descriptor(), 0);
    if (mapped == MAP_FAILED) throw system_error("map", path.native(), errno);
    data_ = static_cast<const std::byte*>(mapped);
  }
  ~Mapping() { ::munmap(const_cast<std::byte*>(data_), bytes_); }
  Mapping(const Mapping&) = delete;
  Mapping& operator=(const Mapping&) = delete;
  const std::byte* data() const { return data_; }
  std::uint64_t bytes() const { return bytes_; }

 private:
  File file_;
  std::uint64_t bytes_;
  const std::byte* data_;
};

/// Calls read(thread, face) for the faces of each thread, and returns nanoseconds of each call.
template <class Read>
std::vector<double> latencies(const std::vector<std::vector<FaceId>>& faces_of, Read read) {
  std::vector<std::vector<double>> times(faces_of.size());
  std::vector<std::thread> threads;
  for (std::size_t thread = 0; thread < faces_of.size(); ++thread)
    threads.emplace_back([&, thread] {
      for (const FaceId face : faces_of[thread])
        times[thread].push_back(1e9 * seconds([&] { read(thread, face); }));
    });
  for (std::thread& thread : threads) thread.join();
  std::vector<double> all;
  for (const std::vector<double>& of : times) all.insert(all.end(), of.begin(), of.end());
  return all;
}

void measure(Row& row, const Reader& reader, const Mapping& mapping, std::uint64_t face_count,
             const Settings& settings, unsigned seed) {
  const std::uint64_t vertices = patch_vertex_count(std::int64_t{1} << settings.level);
  const std::uint64_t patch_bytes = vertices * sizeof(Vector3<float>);
  const std::uint64_t places = mapping.bytes() / patch_bytes;
  const int reads_of_thread = settings.reads / row.threads;
  std::vector<std::vector<FaceId>> faces;
  faces.reserve(static_cast<std::size_t>(row.threads));
  for (int thread = 0; thread < row.threads; ++thread)
    faces.push_back(instrument::draw_faces(row.distribution == "zipf", face_count,
                                           static_cast<std::size_t>(reads_of_thread),
                                           seed + static_cast<unsigned>(thread)));
  std::vector<std::vector<Vector3<float>>> into(faces.size(),
                                                std::vector<Vector3<float>>(vertices));
  const auto count = static_cast<double>(reads_of_thread) * row.threads;
  std::vector<double> times;
  row.reads_per_second.push_back(count / seconds([&] {
                                   times = latencies(faces, [&](std::size_t thread, FaceId face) {
                                     reader.read_patch(face, settings.level)
                                         .attribute<Vector3<float>>("position")
                                         .copy_to(into[thread]);
                                   });
                                 }));
  row.p50.push_back(instrument::quantile(times, 0.5));
  row.p99.push_back(instrument::quantile(times, 0.99));
  row.p999.push_back(instrument::quantile(times, 0.999));
  row.floor_reads_per_second.push_back(count / seconds([&] {
                                         latencies(faces, [&](std::size_t thread, FaceId face) {
                                           std::memcpy(into[thread].data(),
                                                       mapping.data() + face % places * patch_bytes,
                                                       patch_bytes);
                                         });
                                       }));
}

int run(const Settings& settings) {
  const BaseMesh base = octahedron(settings.refinements);
  const fs::path path = fs::path(settings.directory) / "plait-bench.plait";
  const BackendRegistry& backends = default_backends();
  std::vector<Row> rows;
  for (const std::string& backend : settings.backends) {
    say_progress(fmt::format("{}: making a store", backend));
    fs::remove_all(path);
    StoreOptions options;
    options.backend = backend;
    options.block_bytes = settings.block_kibibytes << 10;
    {
      Store store = Store::create(path, base, options, backends);
      add_base_positions(store);
      subdivide(store, {.levels = settings.level});
      store.commit();
    }
    OpenOptions open;
    open.budget_bytes =
        settings.budget_mebibytes == 0 ? std::uint64_t{1} << 34 : settings.budget_mebibytes << 20;
    const Store store = Store::open(path, open, backends);
    const Reader reader(store);
    const Mapping mapping(StoreAccess::level_file(store, 0, settings.level).path);
    for (FaceId face = 0; face < base.face_count(); ++face) reader.read_patch(face, settings.level);
    const std::size_t first = rows.size();
    for (const char* distribution : {"uniform", "zipf"})
      for (const int threads : settings.threads) rows.push_back({backend, distribution, threads});
    for (int turn = 0; turn < settings.runs; ++turn)
      for (std::size_t at = first; at < rows.size(); ++at) {
        say_progress(fmt::format("{}: run {} of {}", backend, turn + 1, settings.runs));
        measure(rows[at], reader, mapping, base.face_count(), settings,
                static_cast<unsigned>(100 * turn));
      }
  }
  fs::remove_all(path);

  instrument::Table table = instrument::table_with(
      "backend|patches|#threads|#reads a second|#copies a second|#time / copy|#p50, ns|#p99, "
      "ns|#p99.9, ns");
  for (const Row& row : rows)
    table.rows.push_back(
        {{row.backend, row.distribution, number(row.threads, 0), spread(row.reads_per_second, 1, 0),
          middle(row.floor_reads_per_second, 1, 0),
          number(*middle(row.floor_reads_per_second).value / *middle(row.reads_per_second).value),
          middle(row.p50, 1, 0), middle(row.p99, 1, 0), middle(row.p999, 1, 0)}});
  print_table(fmt::format("{} patches of {} vertices, float32 positions, {} reads, {} runs, budget "
                          "{} MiB (0: for everything)",
                          base.face_count(), patch_vertex_count(std::int64_t{1} << settings.level),
                          settings.reads, settings.runs, settings.budget_mebibytes),
              table);
  return 0;
}

}  // namespace

int main(int count, char** words) {
  Settings settings;
  return run_program(
      "plait_bench_patch_reads", "Reads of random patches", count, words,
      [&](CommandLine& app) {
        app.add_option("--block", settings.block_kibibytes, "Size of a block, KiB")
            ->range(4, 1 << 20)
            ->capture_default_str();
        add_surface_options(app, settings.refinements, settings.level);
        add_backends_option(app, settings.backends);
        add_threads_option(app, settings.threads);
        app.add_option("--budget", settings.budget_mebibytes,
                       "Budget for blocks in memory, MiB; 0: enough for the whole store")
            ->range(0, 1 << 20);
        add_number_option(app, "--reads", settings.reads, 64, 100000000, "Reads of all threads");
        add_runs_option(app, settings.runs);
        add_directory_option(app, settings.directory);
      },
      [&] { return run(settings); }, &settings.directory);
}
