// Long steps that know nothing of progress ask whether they shall go on, and stop soon.
#include "base/interruption.h"

#include <tbb/task_arena.h>

#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <functional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "base/threads.h"
#include "distance/closest_point.h"
#include "format/base_mesh_file.h"
#include "format/file_names.h"
#include "mesh/weld.h"
#include "mesh_files.h"
#include "plait/error.h"
#include "plait/extend/directory.h"
#include "plait/extend/file.h"
#include "plait/layout.h"
#include "shapes.h"
#include "support/error_of.h"
#include "surface/repair.h"

using namespace plait;
using namespace plait::mesh_files;
using plait::test::error_of;

namespace {

constexpr std::chrono::milliseconds kAlways(0);

/// How often the work asks on a pool of one thread, where the number is the same each time (with
/// more threads, those of the pool may take steps, and they do not ask); `most` answers are yes.
int questions_of(const std::function<void()>& work, int most, bool& was_cancelled) {
  int questions = 0;
  const ProgressCallback progress = [&](const Progress& now) {
    CHECK(now.phase == "trial");
    return ++questions <= most;
  };
  was_cancelled = false;
  tbb::task_arena one_thread(1);
  try {
    one_thread.execute([&] {
      const Interruptible interruptible("trial", progress, kAlways);
      work();
    });
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::kCancelled);
    CHECK_THAT(error.what(), Catch::Contains("trial: cancelled"));
    was_cancelled = true;
  }
  return questions;
}

}  // namespace

TEST_CASE("Interruptible_LongSteps_AskOftenAndStopWhenTheyAreTold") {
  constexpr int kAllYes = 1 << 30;
  const MeshDirectory directory;
  const IndexedMesh mesh = shapes::torus(250, 300);
  const BaseMesh base = BaseMesh::build(mesh);
  std::vector<std::pair<std::string, std::function<void()>>> steps;
  for (const Sample& sample : samples(mesh)) {
    const auto path = directory.file(sample.name, sample.bytes);
    steps.emplace_back(sample.name, [path] { read_indexed_mesh(path); });
  }
  steps.emplace_back("base mesh", [&] { BaseMesh::build(mesh); });
  const StoredSize stored = write_base_mesh_file(Directory(directory.path()), base);
  steps.emplace_back("base mesh of a store", [&] {
    const File file(directory.path() / kBaseMeshName, OpenMode::kRead);
    read_base_mesh_file(file, stored, base.vertex_count(), base.face_count());
  });
  for (const LayoutKind kind :
       {LayoutKind::kSpatial, LayoutKind::kHilbert, LayoutKind::kRcm, LayoutKind::kAutomatic})
    steps.emplace_back("layout " + std::string(to_string(kind)),
                       [&, kind] { lay_out(base, kind); });
  steps.emplace_back("weld", [&] {
    AttributedMesh read{mesh};
    std::vector<std::string> warnings;
    weld(read, 1e-9, "mesh", warnings);
  });
  steps.emplace_back("repair", [&] { repair(mesh, {}, "mesh"); });
  steps.emplace_back("tree", [&] { TriangleTree(mesh.positions, mesh.faces, {}); });
  for (const auto& [name, work] : steps) {
    CAPTURE(name);
    bool was_cancelled = false;
    const int all = questions_of(work, kAllYes, was_cancelled);
    CHECK(all >= 4);
    CHECK_FALSE(was_cancelled);
    for (const int most : {0, all / 2}) {
      CHECK(questions_of(work, most, was_cancelled) == most + 1);
      CHECK(was_cancelled);
    }
  }
}

TEST_CASE("Interruptible_OnWorkers_IsAskedByItsThreadAloneAndAllHearTheAnswer") {
  const auto own = std::this_thread::get_id();
  std::atomic<int> elsewhere = 0;
  bool stop = false;
  const ProgressCallback progress = [&](const Progress&) {
    elsewhere += std::this_thread::get_id() != own ? 1 : 0;
    return !stop;
  };
  const Interruptible interruptible("trial", progress, kAlways);
  each_on_workers(0, 1000, [](int) { poll_interruption(); });
  stop = true;
  // The others could do all before the thread that may ask has its first turn.
  std::atomic<bool> has_turn = false;
  const Error error = error_of([&] {
    each_on_workers(0, 1000, [&](int) {
      if (std::this_thread::get_id() == own) {
        has_turn = true;
        has_turn.notify_all();
      } else {
        has_turn.wait(false);
      }
      poll_interruption();
    });
  });
  CHECK(error.code() == ErrorCode::kCancelled);
  CHECK(elsewhere == 0);
}

TEST_CASE("Interruptible_InsideAnother_StandsForItAndGivesItBack") {
  int outer = 0, inner = 0;
  const ProgressCallback count_outer = [&](const Progress&) { return ++outer > 0; };
  const ProgressCallback count_inner = [&](const Progress&) { return ++inner > 0; };
  poll_interruption();
  {
    const Interruptible first("first", count_outer, kAlways);
    {
      const Interruptible second("second", count_inner, kAlways);
      poll_interruption();
    }
    poll_interruption();
    {
      const ProgressCallback nobody;
      const Interruptible none("none", nobody, kAlways);
      poll_interruption();
    }
  }
  poll_interruption();
  CHECK(outer == 1);
  CHECK(inner == 1);
}

TEST_CASE("Interruptible_ThatWasTold_AsksWithTheSameNumbers") {
  std::vector<std::string> told;
  const ProgressCallback progress = [&](const Progress& now) {
    told.push_back(std::string(now.phase) + " " + std::to_string(now.done) + "/" +
                   std::to_string(now.total));
    return true;
  };
  Interruptible interruptible("trial", progress, kAlways);
  const ProgressCallback passed = interruptible.progress();
  poll_interruption();
  passed({"read", 2, 5});
  poll_interruption();
  CHECK(told == std::vector<std::string>{"trial 0/0", "read 2/5", "read 2/5"});
}
