// For stores of any size, memory stays within the budget and a constant. Each run is a process
// (memory_probe.cpp).
#include <fmt/format.h>
#include <stdio.h>
#include <sys/wait.h>

#include <catch2/catch.hpp>
#include <cstdint>
#include <memory>
#include <sstream>
#include <string>

#include "acceptance/meshes.h"
#include "plait/mesh_io.h"
#include "support/skip.h"
#include "support/temporary_directory.h"
#include "support/usable_backends.h"

using namespace plait;
using namespace plait::test;

namespace {

constexpr std::uint64_t kMebibyte = 1 << 20;
/// The memory that a run may use besides the budget and the base mesh: the program itself, threads,
/// block tables, scratch memory of a codec.
constexpr std::uint64_t kSlackBytes = 24 * kMebibyte;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kCanMeasure = false;
#else
constexpr bool kCanMeasure = true;
#endif

constexpr const char* kCannotMeasure = "the peak would include the shadow memory of the sanitizer";

struct Figures {
  std::uint64_t peak_before_bytes = 0, peak_bytes = 0, base_bytes = 0, level_bytes = 0;
  int base_level = 0;
  std::uint64_t vertices = 0;
  double seconds = 0;

  std::string text(const std::string& what, std::uint64_t budget_bytes) const {
    const auto mebibytes = [](std::uint64_t bytes) {
      return static_cast<double>(bytes) / static_cast<double>(kMebibyte);
    };
    return fmt::format(
        "{}: {} vertices, levels {:.1f} MiB, budget {:.1f} MiB, base mesh {:.1f} MiB, peak {:.1f} "
        "MiB before, {:.1f} MiB after, {:.1f} s",
        what, vertices, mebibytes(level_bytes), mebibytes(budget_bytes), mebibytes(base_bytes),
        mebibytes(peak_before_bytes), mebibytes(peak_bytes), seconds);
  }
};

/// `mesh` must not contain a quote.
Figures measure(const std::string& mesh, int levels, std::uint64_t budget_bytes,
                const std::string& backend, const std::string& executor, int threads,
                bool normals) {
  const TemporaryDirectory directory;
  const std::string command = fmt::format(
      "'{}' '{}' {} {} {} {} {} {} '{}'", PLAIT_MEMORY_PROBE, mesh, levels, budget_bytes, backend,
      executor, threads, normals ? 1 : 0, (directory.path() / "scratch.plait").string());
  INFO(command);
  FILE* const output = ::popen(command.c_str(), "r");
  REQUIRE(output != nullptr);
  std::string text;
  for (int byte = std::fgetc(output); byte != EOF; byte = std::fgetc(output))
    text.push_back(static_cast<char>(byte));
  const int status = ::pclose(output);
  REQUIRE(WIFEXITED(status));
  REQUIRE(WEXITSTATUS(status) == 0);
  Figures figures;
  std::istringstream(text) >> figures.peak_before_bytes >> figures.peak_bytes >>
      figures.base_bytes >> figures.level_bytes >> figures.base_level >> figures.vertices >>
      figures.seconds;
  REQUIRE(figures.vertices > 0);
  return figures;
}

}  // namespace

TEST_CASE("Subdivide_StoreEightTimesTheBudget_StaysWithinIt") {
  if (!kCanMeasure) {
    skip(kCannotMeasure);
    return;
  }
  const TemporaryDirectory directory;
  const std::string mesh = (directory.path() / "mesh.ply").string();
  write_ply(mesh, generated_meshes(26'016).front().make());
  const int levels = is_full_run() ? 5 : 4;
  const std::uint64_t budget_bytes = (is_full_run() ? 72 : 18) * kMebibyte;
  for (const std::string& backend : usable_backends()) {
    if (backend == "memory") continue;
    for (const std::string executor : {"fused", "sweep", "transparent"})
      for (const int threads : {1, 4}) {
        if (executor == "transparent" && threads > 1)
          continue;  // the transparent executor has only one thread
        const Figures figures =
            measure(mesh, levels, budget_bytes, backend, executor, threads, true);
        const std::string text =
            figures.text(fmt::format("{} {} {}", backend, executor, threads), budget_bytes);
        INFO(text);
        REQUIRE(figures.level_bytes >= 8 * budget_bytes);
        CHECK(figures.peak_bytes < figures.base_bytes + budget_bytes + kSlackBytes);
        std::printf("%s\n", text.c_str());
      }
  }
}

TEST_CASE("Subdivide_IcosahedronToADeepLevel_StaysWithinItsBudget") {
  if (!kCanMeasure) {
    skip(kCannotMeasure);
    return;
  }
  constexpr std::uint64_t kBudgetBytes = 64 * kMebibyte;
  constexpr int kLevels = 11;
  const Figures figures = measure("icosahedron", kLevels, kBudgetBytes, "pread", "sweep", 2, false);
  WARN(figures.text(fmt::format("icosahedron to level {}", kLevels), kBudgetBytes));
  CHECK(figures.base_level > 0);
  CHECK(figures.vertices == (std::uint64_t{10} << (2 * kLevels)) + 2);
  CHECK(figures.peak_bytes < figures.base_bytes + kBudgetBytes + kSlackBytes);
}
