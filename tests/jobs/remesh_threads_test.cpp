// A scan becomes a store by any number of threads, which stop in every phase if they are asked to.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "plait/error.h"
#include "remesh/remesh.h"
#include "remesh_files.h"
#include "support/error_of.h"
#include "support/parallel_loops.h"
#include "support/sanitized.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

namespace fs = std::filesystem;

constexpr int kFaces = unless_sanitized(200, 80);
IndexedMesh small_torus() { return torus_grid(unless_sanitized(60, 30), unless_sanitized(40, 20)); }

}  // namespace

TEST_CASE("Remesh_AnyNumberOfThreads_GivesTheSameDigest") {
  const RemeshFiles files;
  write_with_attributes(files.scan, with_noise(small_torus(), 0.01));
  std::vector<std::string> digests;
  for (const int threads : {1, 2, 3}) {
    RemeshRequest request = files.request(kFaces);
    request.threads = threads;
    request.digest = true;
    digests.push_back(files.run(request).digest);
  }
  CHECK(!digests[0].empty());
  CHECK(digests[1] == digests[0]);
  CHECK(digests[2] == digests[0]);
  for (const NamedLoop& pool : parallel_loops()) {
    CAPTURE(pool.name);
    RemeshRequest request = files.request(kFaces);
    request.threads = 3;
    request.digest = true;
    request.options.parallel_for = pool.loop;
    CHECK(files.run(request).digest == digests[0]);
  }
}

TEST_CASE("Remesh_WithMoreThreadsThanTheBudgetHolds_TakesFewerAndSaysSo") {
  constexpr int kMany = 600;
  const RemeshFiles files;
  write_with_attributes(files.scan, small_torus());
  std::vector<std::string> warnings;
  const JobWatch watch{.warn = [&](const std::string& warning) { warnings.push_back(warning); }};
  RemeshRequest request = files.request(kFaces, 4);
  request.options.budget_bytes = 1 << 20;
  request.digest = true;
  const std::string digest = files.run(request, watch).digest;
  const auto of_threads = [&] {
    return std::ranges::count_if(warnings, [](const std::string& warning) {
      return warning.find("threads of " + std::to_string(kMany)) != std::string::npos;
    });
  };
  CHECK(of_threads() == 0);
  request.threads = kMany;
  CHECK(files.run(request, watch).digest == digest);
  CHECK(of_threads() > 0);
}

TEST_CASE("Remesh_OnThePoolOfTheProgram_WritesEachAttributeOfTheScanThere") {
  const RemeshFiles files;
  int loops = 0;
  RemeshRequest request = files.request(kFaces);
  request.options.parallel_for = [&](int count, const std::function<void(int)>& body) {
    ++loops;
    for (int number = 0; number < count; ++number) body(number);
  };
  write_ply(files.scan, small_torus());
  files.run(request);
  const int of_positions = std::exchange(loops, 0);
  write_with_attributes(files.scan, small_torus());
  const RemeshReport report = files.run(request);
  CHECK(of_positions > 0);
  CHECK(report.attributes.size() == 4);
  CHECK(loops == of_positions + 4);
}

TEST_CASE("Remesh_EveryCancelledPhase_LeavesNothing") {
  const RemeshFiles files;
  write_with_attributes(files.scan, flat_sheet(20, 20));
  std::vector<std::string> phases;
  files.run(files.request(40), {.progress = [&](const Progress& now) {
              if (phases.empty() || phases.back() != now.phase) phases.emplace_back(now.phase);
              return true;
            }});
  CHECK(phases.size() > 8);
  fs::remove_all(files.store);
  for (const std::string& phase : phases) {
    CAPTURE(phase);
    const Error error = error_of([&] {
      files.run(files.request(40),
                {.progress = [&](const Progress& now) { return now.phase != phase; }});
    });
    CHECK(error.code() == ErrorCode::kCancelled);
    CHECK(std::distance(fs::directory_iterator(files.directory.path()), fs::directory_iterator()) ==
          1);
  }
}

}  // namespace plait::test
