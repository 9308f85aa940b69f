// How fast is one read-modify-write sweep over data several times larger than memory on each
// backend, compared with a program that only reads and writes the same bytes in the same way?
//
//   plait_bench_sweep_rmw [--level 7] [--refinements 5] [--components 6] [--limit MIB]
//                         [--memory MIB] [--threads 2] [--runs 5] [--drop-caches 1]
//                         [--io-threads N] [--only BACKEND] [--modes scratch] [--directory .]
//                         [--json FILE]
//
// The sweep adds 1 to every float of the finest level. Each run is a process under the memory limit
// (a cgroup; the program says so if it may not set one), with a cold page cache and with
// fdatasync inside the time. --modes names what the sweep is, several with commas: "scratch", in
// place without a way back; "generation", a durable commit of a new file for the level; "journal",
// a durable commit in place. The modes take turns, so a change of the disk's speed affects all.
// After each turn comes the floor. The floor is fio, which reads and writes the same bytes in
// blocks of the same size (uring: io_uring with O_DIRECT, eight blocks in each direction; pread and
// compressed: psync). For mmap the floor is a plain loop over a mapping; without fio it is a plain
// loop for all backends. For a generation it is a plain loop that reads one file, writes another
// one and removes the first. The program prints a Markdown table of medians with the smallest and
// largest values.
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "command_line.h"
#include "confined.h"
#include "plait/backends/registry.h"
#include "plait/file.h"
#include "plait/store.h"
#include "plait/sweep.h"
#include "support.h"

namespace {

using namespace plait;
using namespace plait::bench;
namespace fs = std::filesystem;

struct Settings {
  int level = 7, refinements = 5, runs = 5, threads = 2;
  std::uint32_t components = 6;
  std::uint64_t limit_mebibytes = 256, memory_mebibytes = 64;
  int drop_caches = 1, io_threads = -1;  ///< -1: the store's default
  std::vector<std::string> modes = {"scratch"};
  std::string directory = ".", only, json;
};

struct Mode {
  std::string name;
  Durability durability;
  Overwriting overwriting;
};
const std::vector<Mode> kModes = {{"scratch", Durability::kNone, Overwriting::kInPlace},
                                  {"generation", Durability::kCommit, Overwriting::kNewGeneration},
                                  {"journal", Durability::kCommit, Overwriting::kInPlace}};

struct Subject {
  std::string name, backend, engine;
};
const std::vector<Subject> kSubjects = {{"pread", "pread", "psync"},
                                        {"uring", "uring", "io_uring"},
                                        {"mmap", "mmap", ""},
                                        {"compressed lz4", "compressed", "psync"}};

void sweep_finest(Store& store, const Settings& settings, Access access) {
  SweepPass pass;
  pass.name = "read, modify, write";
  pass.accesses = {{0, settings.level, settings.level, access, Reach::kOwn}};
  pass.kernel = [&](const SweepView& view, EdgeId edge, int) {
    const std::span<std::byte> slot = view.slot(0, settings.level, edge);
    auto* const values = reinterpret_cast<float*>(slot.data());
    const std::size_t count = slot.size() / sizeof(float);
    if (access == Access::kOverwrite)
      for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<float>(edge + (i >> 4));
    else
      for (std::size_t i = 0; i < count; ++i) values[i] += 1.0f;
  };
  SweepOptions options;
  options.threads = settings.threads;
  sweep(store, pass, options);
  store.commit();
}

void make_store(const fs::path& path, const BaseMesh& base, const Settings& settings,
                const Subject& subject) {
  fs::remove_all(path);
  StoreOptions options;
  options.backend = subject.backend;
  if (subject.backend == "compressed") options.pipeline = "shuffle,lz4";
  Store store = Store::create(path, base, options, default_backends());
  const AttributeId attribute =
      store.add_attribute({"value", ComponentType::kFloat32, settings.components});
  for (int level = 1; level <= settings.level; ++level) store.add_level(attribute);
  sweep_finest(store, settings, Access::kOverwrite);
}

double sweep_seconds(const fs::path& path, const Settings& settings, const Mode& mode) {
  OpenOptions options;
  options.writable = true;
  options.budget_bytes = settings.memory_mebibytes << 20;
  options.durability = mode.durability;
  options.overwriting = mode.overwriting;
  if (settings.io_threads >= 0) options.io_threads = settings.io_threads;
  Store store = Store::open(path, options, default_backends());
  const double result = seconds([&] {
    sweep_finest(store, settings, Access::kUpdate);
    if (mode.durability == Durability::kNone)
      File(store.level_file(0, settings.level).path, OpenMode::kReadWrite).sync();
  });
  const PagingStatistics paging = store.statistics();
  fmt::print(stderr, "  {:.2f} s, waited {:.2f} s for reads and {:.2f} s for writes\n", result,
             1e-9 * double(paging.read_wait_ns), 1e-9 * double(paging.write_wait_ns));
  return result;
}

double mapping_seconds(const fs::path& path, std::uint64_t bytes) {
  File file(path, OpenMode::kReadWrite);
  return seconds([&] {
    void* const mapped =
        ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file.descriptor(), 0);
    if (mapped == MAP_FAILED) throw system_error("map", path.native(), errno);
    auto* const values = static_cast<float*>(mapped);
    for (std::uint64_t i = 0; i < bytes / sizeof(float); ++i) values[i] += 1.0f;
    if (::msync(mapped, bytes, MS_SYNC) != 0) throw system_error("sync", path.native(), errno);
    ::munmap(mapped, bytes);
  });
}

double plain_seconds(const fs::path& path, std::uint64_t bytes, std::uint64_t block_bytes,
                     Caching caching) {
  File file(path, OpenMode::kReadWrite, caching);
  auto* const memory = static_cast<std::byte*>(::operator new(block_bytes, std::align_val_t(4096)));
  const double result = seconds([&] {
    for (std::uint64_t at = 0; at < bytes; at += block_bytes) {
      file.read_at(at, {memory, block_bytes});
      file.write_at(at, {memory, block_bytes});
    }
    file.sync();
  });
  ::operator delete(memory, std::align_val_t(4096));
  return result;
}

/// What a new generation does to the disk: reads one file, writes another one, and removes the
/// first.
double copy_seconds(const fs::path& path, std::uint64_t bytes, std::uint64_t block_bytes,
                    Caching caching) {
  const fs::path copy = path.native() + ".copy";
  fs::remove(copy);
  auto* const memory = static_cast<std::byte*>(::operator new(block_bytes, std::align_val_t(4096)));
  const double result = seconds([&] {
    {
      const File from(path, OpenMode::kRead, caching);
      File to(copy, OpenMode::kCreate, caching);
      to.preallocate(bytes);
      for (std::uint64_t at = 0; at < bytes; at += block_bytes) {
        const std::span<std::byte> part(memory, std::min(block_bytes, bytes - at));
        from.read_at(at, part);
        to.write_at(at, part);
        if (caching == Caching::kPageCache)
          ::sync_file_range(to.descriptor(), static_cast<off_t>(at),
                            static_cast<off_t>(part.size()), SYNC_FILE_RANGE_WRITE);
      }
      to.sync();
    }
    fs::rename(copy, path);
  });
  ::operator delete(memory, std::align_val_t(4096));
  return result;
}

double fio_seconds(const fs::path& path, std::uint64_t bytes, std::uint64_t block_bytes,
                   const std::string& engine) {
  const bool direct = engine == "io_uring";
  const std::string text = output_of(fmt::format(
      "fio --name=floor --filename={} --rw=rw --rwmixread=50 --size={} --io_size={} --bs={} "
      "--ioengine={} --direct={} --iodepth={} --output-format=json 2>/dev/null",
      path.native(), bytes, 2 * bytes, block_bytes, engine, direct ? 1 : 0, direct ? 16 : 1));
  if (text.empty()) throw Error(ErrorCode::kIo, "fio failed");
  const nlohmann::json job = nlohmann::json::parse(text.substr(text.find('{')))["jobs"][0];
  const double moved =
      job["read"]["io_bytes"].get<double>() + job["write"]["io_bytes"].get<double>();
  // fio's time does not include a sync.
  const double sync = seconds([&] { File(path, OpenMode::kReadWrite).sync(); });
  return job["job_runtime"].get<double>() / 1000 * (2 * double(bytes) / moved) + sync;
}

double floor_seconds(const fs::path& path, std::uint64_t bytes, std::uint64_t block_bytes,
                     const Subject& subject, bool have_fio) {
  if (subject.engine.empty()) return mapping_seconds(path, bytes);
  if (have_fio) return fio_seconds(path, bytes, block_bytes, subject.engine);
  return plain_seconds(path, bytes, block_bytes,
                       subject.engine == "psync" ? Caching::kPageCache : Caching::kNone);
}

void make_floor_file(const fs::path& path, std::uint64_t bytes, std::uint64_t block_bytes) {
  fs::remove(path);
  File file(path, OpenMode::kCreate);
  file.preallocate(bytes);
  const std::vector<std::byte> block(block_bytes, std::byte{1});
  for (std::uint64_t at = 0; at < bytes; at += block_bytes) file.write_at(at, block);
  file.sync();
}

struct Times {
  std::string subject, mode;
  std::vector<double> sweep, floor;
};

/// The floor's file and those of the level, whatever their generation.
std::vector<fs::path> files_read(const fs::path& floor_file, const fs::path& store, int level) {
  std::vector<fs::path> files = {floor_file};
  const std::string prefix = fmt::format("attribute0.level{:02}.", level);
  for (const fs::directory_entry& entry : fs::directory_iterator(store))
    if (entry.path().filename().string().starts_with(prefix)) files.push_back(entry.path());
  return files;
}

std::string spread(const std::vector<double>& values, double bytes) {
  return fmt::format("{:.2f} ({:.2f} to {:.2f})", 2e-9 * bytes / median(values),
                     2e-9 * bytes / std::ranges::max(values),
                     2e-9 * bytes / std::ranges::min(values));
}

int run(const Settings& settings) {
  const BaseMesh base = octahedron(settings.refinements);
  const LevelGeometry geometry(base.slot_shapes(), BaseRelativeLevel(settings.level),
                               settings.components * sizeof(float), StoreOptions().block_bytes);
  const std::uint64_t bytes = geometry.total_bytes(), block_bytes = geometry.max_block_bytes();
  const MemoryLimit limit(settings.limit_mebibytes << 20);
  const bool have_fio = !output_of("fio --version 2>/dev/null").empty();
  const fs::path floor_file = fs::path(settings.directory) / "plait-bench.floor";
  make_floor_file(floor_file, bytes, block_bytes);

  bool cold = true;
  std::vector<Times> times;
  for (const Subject& subject : kSubjects) {
    if (!settings.only.empty() && settings.only != subject.backend) continue;
    const fs::path path = fs::path(settings.directory) / "plait-bench.plait";
    say_progress(fmt::format("{}: making a store", subject.name));
    make_store(path, base, settings, subject);
    const auto make_all_cold = [&] {
      return settings.drop_caches != 0 && make_cold(files_read(floor_file, path, settings.level));
    };
    const std::size_t first = times.size();
    for (const Mode& mode : kModes)
      if (std::ranges::find(settings.modes, mode.name) != settings.modes.end())
        times.push_back({subject.name, mode.name, {}, {}});
    for (int turn = 0; turn < settings.runs; ++turn) {
      say_progress(fmt::format("{}: run {} of {}", subject.name, turn + 1, settings.runs));
      for (std::size_t at = first; at < times.size(); ++at) {
        const Mode& mode = *std::ranges::find(kModes, times[at].mode, &Mode::name);
        cold = make_all_cold();
        times[at].sweep.push_back(
            run_for_figure(limit, [&] { return sweep_seconds(path, settings, mode); }));
      }
      const auto cold_seconds = [&](const auto& floor) {
        make_all_cold();
        return run_for_figure(limit, floor);
      };
      const double in_place = cold_seconds(
          [&] { return floor_seconds(floor_file, bytes, block_bytes, subject, have_fio); });
      const double copied = cold_seconds([&] {
        return copy_seconds(floor_file, bytes, block_bytes,
                            subject.engine == "io_uring" ? Caching::kNone : Caching::kPageCache);
      });
      for (std::size_t at = first; at < times.size(); ++at)
        times[at].floor.push_back(times[at].mode == "generation" ? copied : in_place);
    }
    fs::remove_all(path);
  }
  fs::remove(floor_file);

  fmt::print(
      "{} bytes read and written in blocks of {}, {}, {}, {} threads, frames {} MiB, "
      "floors by {}, {} runs\n\n",
      bytes, block_bytes,
      limit.limited() ? fmt::format("memory limit {} MiB", settings.limit_mebibytes)
                      : "no memory limit (not permitted)",
      cold ? "cold"
      : settings.drop_caches != 0
          ? "page cache not dropped (not permitted), only the pages of the files"
          : "warm",
      settings.threads, settings.memory_mebibytes, have_fio ? "fio" : "plain loops", settings.runs);
  fmt::print(
      "| backend | mode | sweep, GB/s read + written (min to max) | floor | sweep / floor |\n"
      "|---|---|---|---|---|\n");
  nlohmann::ordered_json report;
  for (const Times& of : times) {
    const double ratio = median(of.floor) / median(of.sweep);
    fmt::print("| {} | {} | {} | {} | {:.2f} |\n", of.subject, of.mode,
               spread(of.sweep, double(bytes)), spread(of.floor, double(bytes)), ratio);
    report.push_back({{"backend", of.subject},
                      {"mode", of.mode},
                      {"bytes", bytes},
                      {"sweep_seconds", of.sweep},
                      {"floor_seconds", of.floor},
                      {"ratio", ratio}});
  }
  write_json(settings.json, report);
  return 0;
}

}  // namespace

int main(int count, char** words) {
  Settings settings;
  return run_program(
      "plait_bench_sweep_rmw", "One read-modify-write sweep, larger than memory", count, words,
      [&](CommandLine& app) {
        add_number_option(app, "--level", settings.level, 1, 12, "The level that is swept");
        add_number_option(app, "--refinements", settings.refinements, 0, 10,
                          "Refinements of the octahedron that give the base mesh");
        app.add_option("--components", settings.components, "Numbers per record")->range(1, 255);
        app.add_option("--limit", settings.limit_mebibytes, "Memory of the process, MiB (cgroup)")
            ->range(1, 1 << 20);
        app.add_option("--memory", settings.memory_mebibytes, "Budget for blocks in memory, MiB")
            ->range(1, 1 << 20);
        add_number_option(app, "--threads", settings.threads, 1, 64, "Threads that compute");
        add_runs_option(app, settings.runs);
        add_number_option(app, "--drop-caches", settings.drop_caches, 0, 1,
                          "1: the page cache is cold before each run");
        add_number_option(app, "--io-threads", settings.io_threads, -1, 64,
                          "Threads that read ahead and write behind; -1: the store's default");
        app.add_option("--only", settings.only, "Only this backend");
        app.add_option("--modes", settings.modes,
                       "scratch, generation, journal; several with commas")
            ->delimiter(',')
            ->one_of({"scratch", "generation", "journal"});
        add_directory_option(app, settings.directory);
        add_json_option(app, settings.json);
      },
      [&] { return run(settings); }, &settings.directory);
}
