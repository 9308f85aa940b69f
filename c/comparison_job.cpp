// The job that measures how far two surfaces are from each other.
#include <fmt/format.h>

#include "compare/compare.h"
#include "guard.h"
#include "handles.h"
#include "job_options.h"
#include "plait.h"
#include "plugins.h"
#include "sized.h"

namespace plait::c {
namespace {

ComparisonRequest comparison_request_of(const plait_comparison_request& wanted) {
  check_given(wanted.first_path, "first_path");
  check_given(wanted.second_path, "second_path");
  ComparisonRequest request;
  request.first = wanted.first_path;
  request.second = wanted.second_path;
  request.level = wanted.level;
  if (wanted.samples != 0) request.samples = wanted.samples;
  if (wanted.threads < 0)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("threads: expected 0 or more, found {}", wanted.threads));
  if (wanted.threads != 0) request.threads = wanted.threads;
  return request;
}

plait_surface_distances distances_of(const Distances& found) {
  return {found.samples,       found.max,
          found.rms,           found.mean,
          found.percentile_99, found.percentile_99_9,
          found.mean_angle,    found.percentile_99_angle};
}

}  // namespace
}  // namespace plait::c

using namespace plait::c;

plait_status plait_job_compare(const plait_comparison_request* request,
                               plait_comparison_result* result) {
  return guarded("plait_job_compare", [&] {
    check_given(request, "request");
    const plait_comparison_request wanted =
        options_of(request, plait_comparison_request PLAIT_COMPARISON_REQUEST_INIT);
    check_result(result, "result");
    plait::ComparisonWatch watch;
    if (wanted.progress != nullptr) watch.progress = progress_by(wanted.progress, wanted.user);
    watch.warn = warnings_by(wanted.warn, wanted.user);
    const plait::SurfaceComparison done =
        plait::compare_surfaces(comparison_request_of(wanted), known_backends(), watch);
    plait_comparison_result filled = PLAIT_COMPARISON_RESULT_INIT;
    filled.diagonal = done.diagonal;
    filled.mean_edge = done.mean_edge;
    filled.there = distances_of(done.there);
    filled.back = distances_of(done.back);
    fill(result, filled);
  });
}
