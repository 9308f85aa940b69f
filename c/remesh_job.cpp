// The job that makes a store of a scan.
#include <algorithm>
#include <cstdint>
#include <cstring>

#include "guard.h"
#include "handles.h"
#include "job_options.h"
#include "plait.h"
#include "plugins.h"
#include "remesh/remesh.h"
#include "sized.h"

namespace plait::c {
namespace {

RemeshRequest remesh_request_of(const plait_remesh_request& wanted) {
  check_given(wanted.scan_path, "scan_path");
  check_given(wanted.store_path, "store_path");
  check_choice("existing", wanted.existing, 2);
  RemeshRequest request;
  request.scan = wanted.scan_path;
  request.store = wanted.store_path;
  request.faces = wanted.faces;
  if (wanted.levels != 0) request.levels = wanted.levels;
  request.repair.min_component = wanted.min_component;
  request.repair.fill_holes = wanted.fill_holes;
  request.refuse_turned = wanted.refuse_turned != 0;
  request.report_samples = wanted.samples;
  request.options.backend = text_or(wanted.backend, request.options.backend);
  if (wanted.budget_bytes != 0) request.options.budget_bytes = wanted.budget_bytes;
  if (wanted.threads != 0) request.threads = wanted.threads;
  request.digest = wanted.digest != 0;
  request.distances = wanted.distances != 0;
  request.ignore_size = wanted.ignore_size != 0;
  request.weld = weld_of(wanted.weld, wanted.weld_tolerance);
  request.precision = precision_of(wanted.precision);
  request.replace = wanted.existing == PLAIT_EXISTING_REPLACE;
  return request;
}

plait_remesh_result remesh_result_of(const RemeshReport& done) {
  plait_remesh_result result = PLAIT_REMESH_RESULT_INIT;
  result.scan_faces = done.scan.faces;
  result.base_vertices = done.base.vertices;
  result.base_faces = done.base.faces;
  result.vertices = done.vertices;
  result.faces = done.small_faces;
  result.turned_faces = done.turned;
  result.stored_bytes = done.stored_bytes;
  result.diagonal = done.diagonal;
  result.mean_edge = done.mean_edge;
  result.scan_to_store_rms = done.to_store.rms;
  result.scan_to_store_max = done.to_store.max;
  result.store_to_scan_rms = done.to_scan.rms;
  result.store_to_scan_max = done.to_scan.max;
  result.area_spread_percentile_90 = done.area_spread.percentile_90;
  result.area_spread_share_within_4 = done.area_spread.share_within_4;
  result.base_meshes = static_cast<std::int32_t>(done.base_meshes);
  std::memcpy(result.digest, done.digest.c_str(),
              std::min(done.digest.size() + 1, sizeof(result.digest)));
  return result;
}

}  // namespace
}  // namespace plait::c

using namespace plait::c;

plait_status plait_job_remesh(const plait_remesh_request* request, plait_remesh_result* result) {
  return guarded("plait_job_remesh", [&] {
    check_given(request, "request");
    const plait_remesh_request wanted =
        options_of(request, plait_remesh_request PLAIT_REMESH_REQUEST_INIT);
    if (result != nullptr) check_result(result, "result");
    plait::RemeshWatch watch;
    if (wanted.progress != nullptr) watch.progress = progress_by(wanted.progress, wanted.user);
    watch.warn = warnings_by(wanted.warn, wanted.user);
    const plait::RemeshReport done =
        plait::remesh(remesh_request_of(wanted), known_backends(), watch);
    if (result != nullptr) fill(result, remesh_result_of(done));
  });
}
