// How long does a Loop subdivision with normals take on each backend, beside the floors that no
// backend can pass: copying the same bytes in memory, and writing them to a file without computing?
//
//   plait_bench_subdivide [--mesh FILE] [--levels 5] [--runs 5] [--threads 2] [--memory MIB]
//                         [--executor sweep|transparent] [--directory .]
//
// Without a mesh: an octahedron, refined in memory to 8192 faces. Every run does backend after
// backend and after each its floors, so that a machine whose speed drifts spoils neither. Warm page
// cache; stores end with fdatasync inside the time, and so does the written floor. One run before
// the counted ones. Prints a Markdown table of medians, with the smallest and largest time.
#include "plait/kernels/subdivide.h"

#include <fmt/format.h>
#include <sys/utsname.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "default_mesh.h"
#include "plait/backends/registry.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/file.h"
#include "plait/layout.h"
#include "plait/mesh_io.h"
#include "plait/store.h"

namespace {

using namespace plait;
namespace fs = std::filesystem;

struct Settings {
  std::string mesh, executor = "sweep", directory = ".";
  int levels = 5, runs = 5, threads = 2;
  std::uint64_t budget_bytes = 256 << 20;
};

struct Subject {
  std::string name, backend, codec;
};
const std::vector<Subject> kSubjects = {{"memory", "memory", "none"},
                                        {"pread", "pread", "none"},
                                        {"mmap", "mmap", "none"},
                                        {"compressed lz4", "compressed", "lz4"},
                                        {"compressed zstd:1", "compressed", "zstd:1"}};

struct Times {
  std::vector<double> store, copy, write;
  std::uint64_t raw_bytes = 0, stored_bytes = 0, vertices = 0;
  std::string digest;
};

template <class Work>
double seconds(Work work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

void run_store(const LaidOutMesh& base, const Settings& settings, const Subject& subject,
               Times& times) {
  StoreOptions options;
  options.backend = subject.backend;
  options.backend_options.codec = subject.codec;
  options.budget_bytes = settings.budget_bytes;
  options.layout = std::string(to_string(base.kind));
  SubdivideOptions subdivide_options;
  subdivide_options.levels = settings.levels;
  subdivide_options.normals = true;
  subdivide_options.threads = settings.threads;
  subdivide_options.executor = executor_from_name(settings.executor);
  const fs::path path = fs::path(settings.directory) / "plait-bench.plait";
  fs::remove_all(path);
  const bool in_memory = subject.backend == "memory";
  BaseMesh copy = base.mesh;
  std::unique_ptr<Store> store;
  times.store.push_back(seconds([&] {
    store = std::make_unique<Store>(
        Store::create(in_memory ? fs::path() : path, std::move(copy), options, default_backends()));
    add_base_positions(*store);
    subdivide(*store, subdivide_options);
    store->commit();
  }));
  times.stored_bytes = store->stored_bytes();
  times.digest = digest(*store).to_string();
  times.raw_bytes = times.vertices = 0;
  for (AttributeId id = 0; id < store->attributes().size(); ++id) {
    times.raw_bytes += store->base_bytes(id).size();
    for (int level = store->base_level() + 1; level <= store->finest_level(); ++level)
      times.raw_bytes += store->level_file(id, level).geometry.total_bytes();
  }
  times.vertices = counts_at_level(base.mesh, settings.levels).vertices;
  store.reset();
  fs::remove_all(path);
}

/// The same bytes from one buffer into another that is in memory already.
double copy_floor(std::vector<std::byte>& from, std::vector<std::byte>& to, std::uint64_t bytes) {
  return seconds([&] {
    for (std::uint64_t done = 0; done < bytes; done += from.size())
      std::memcpy(to.data(), from.data(), std::min<std::uint64_t>(from.size(), bytes - done));
  });
}

double write_floor(const std::vector<std::byte>& from, const Settings& settings,
                   std::uint64_t bytes) {
  const fs::path path = fs::path(settings.directory) / "plait-bench.floor";
  fs::remove(path);
  const double result = seconds([&] {
    File file(path, OpenMode::kCreate);
    constexpr std::uint64_t kTransfer = 1 << 20;
    for (std::uint64_t done = 0; done < bytes; done += kTransfer)
      file.write_at(done, std::span(from).subspan(done % (from.size() - kTransfer),
                                                  std::min(kTransfer, bytes - done)));
    file.sync();
    file.close();
  });
  fs::remove(path);
  return result;
}

Settings parse(int count, char** words) {
  Settings settings;
  std::map<std::string, std::string> given;
  for (int i = 1; i + 1 < count; i += 2) given[words[i]] = words[i + 1];
  const auto number = [&](const char* name, auto& value) {
    if (given.contains(name))
      value = static_cast<std::remove_reference_t<decltype(value)>>(std::stoll(given.at(name)));
  };
  const auto text = [&](const char* name, std::string& value) {
    if (given.contains(name)) value = given.at(name);
  };
  text("--mesh", settings.mesh);
  text("--executor", settings.executor);
  text("--directory", settings.directory);
  number("--levels", settings.levels);
  number("--runs", settings.runs);
  number("--threads", settings.threads);
  std::uint64_t mebibytes = settings.budget_bytes >> 20;
  number("--memory", mebibytes);
  settings.budget_bytes = mebibytes << 20;
  if (count % 2 == 0 || settings.runs < 1)
    throw Error(ErrorCode::kInvalidArgument, "expected pairs of --option value, and runs >= 1");
  return settings;
}

int run(const Settings& settings) {
  const LaidOutMesh base =
      lay_out(settings.mesh.empty() ? bench::refined_octahedron(5) : read_base_mesh(settings.mesh),
              LayoutKind::kAutomatic);
  std::vector<Times> times(kSubjects.size());
  std::vector<std::byte> from(64 << 20), to(64 << 20);
  for (std::size_t i = 0; i < from.size(); ++i)
    from[i] = static_cast<std::byte>(i * 2654435761u >> 13);
  for (int turn = 0; turn <= settings.runs; ++turn) {
    if (turn == 1)
      for (Times& of : times) of = {};
    for (std::size_t i = 0; i < kSubjects.size(); ++i) {
      run_store(base, settings, kSubjects[i], times[i]);
      times[i].copy.push_back(copy_floor(from, to, times[i].raw_bytes));
      times[i].write.push_back(write_floor(from, settings, times[i].stored_bytes));
    }
  }

  utsname machine{};
  ::uname(&machine);
  fmt::print(
      "{} vertices at level {}, {} bytes raw, executor {}, {} threads, budget {} MiB, layout "
      "{}, {} runs; {} {}\n\n",
      times[0].vertices, settings.levels, times[0].raw_bytes, settings.executor, settings.threads,
      settings.budget_bytes >> 20, to_string(base.kind), settings.runs, machine.sysname,
      machine.machine);
  fmt::print(
      "| backend | seconds (min to max) | ns a vertex | memcpy, s | write + fdatasync, s | over "
      "memcpy | over write | stored / raw |\n|---|---|---|---|---|---|---|---|\n");
  bool same = true;
  for (std::size_t i = 0; i < kSubjects.size(); ++i) {
    const Times& of = times[i];
    const double store = median(of.store), copy = median(of.copy), write = median(of.write);
    fmt::print(
        "| {} | {:.2f} ({:.2f} to {:.2f}) | {:.0f} | {:.3f} | {:.2f} | {:.1f} | {} | {:.2f} |\n",
        kSubjects[i].name, store, *std::ranges::min_element(of.store),
        *std::ranges::max_element(of.store), 1e9 * store / double(of.vertices), copy, write,
        store / copy, kSubjects[i].backend == "memory" ? "-" : fmt::format("{:.2f}", store / write),
        double(of.stored_bytes) / double(of.raw_bytes));
    same = same && of.digest == times[0].digest;
  }
  fmt::print("\ndigest {}{}\n", times[0].digest, same ? ", the same on every backend" : "");
  if (!same) throw Error(ErrorCode::kCorruption, "the digests differ");
  return 0;
}

}  // namespace

int main(int count, char** words) {
  try {
    return run(parse(count, words));
  } catch (const std::exception& error) {
    fmt::print(stderr, "plait_bench_subdivide: {}\n", error.what());
    return 1;
  }
}
