// examples/watched_job.cpp: a subdivision that a program plans, watches, cancels and resumes.
//
//   watched_job MESH.ply STORE LEVELS [SECONDS]     cancels itself after SECONDS; run it again
//
// With `resume` every level is committed, so that the next run goes on from there.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "plait/error.h"
#include "plait/registry.h"
#include "plait/subdivision_job.h"

int main(int count, char** arguments) try {
  if (count < 4) return std::puts("watched_job MESH.ply STORE LEVELS [SECONDS]"), 2;
  plait::SubdivisionRequest request{.mesh = arguments[1], .store = arguments[2]};
  request.levels = std::atoi(arguments[3]);
  request.resume = true;
  plait::SubdivisionJob job(request, plait::default_backends());
  for (const plait::SubdivisionRefusal& refusal : job.plan().refusals)
    std::printf("refused: %s\n", refusal.reason.c_str());
  std::printf("continues from level %d; needs %.1f MiB on the disk\n",
              job.plan().earlier ? job.plan().earlier->level : 0,
              double(job.plan().size.disk_bytes) / (1 << 20));

  const auto start = std::chrono::steady_clock::now();
  const std::chrono::duration<double> most(count > 4 ? std::atof(arguments[4]) : 1e9);
  plait::JobWatch watch;
  watch.progress = [&](const plait::Progress& now) {
    std::printf("\r%-30.*s %3.0f %%", int(now.phase.size()), now.phase.data(),
                now.total == 0 ? 0 : 100 * double(now.done) / double(now.total));
    return std::chrono::steady_clock::now() - start < most;  // false cancels
  };
  const plait::SubdivisionResult result = job.run(watch);
  std::printf("\r%s: level %d, %llu vertices\n", result.store.c_str(), request.levels,
              static_cast<unsigned long long>(result.plan.level_counts.back().vertices));
} catch (const plait::Error& error) {
  std::printf("\n%s\n", error.what());
  return error.code() == plait::ErrorCode::kCancelled ? 3 : 1;
}
