// The job that makes a store from the mesh of a file.
#include "plait/subdivision_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "guard.h"
#include "handles.h"
#include "job_options.h"
#include "plait.h"
#include "plait/compression.h"
#include "plugins.h"
#include "sized.h"

namespace plait::c {
namespace {

void set_pipelines(const plait_subdivision_request& wanted, SubdivisionRequest& request) {
  request.max_errors = bounds_of(wanted.max_errors, wanted.max_error_count);
  const Compression compression = compression_of(wanted.compress, wanted.compress_count);
  const bool rounds = !request.max_errors.empty();
  const bool compresses = request.backend
                              ? *request.backend != kAutomaticBackend &&
                                    known_backends().find(*request.backend).traits.compressed
                              : rounds;
  if (!compression.empty() || (rounds && compresses))
    request.pipeline_of = [compression](const AttributeSchema& schema) {
      return compression.pipeline_of(schema);
    };
}

SubdivisionRequest request_of(const plait_subdivision_request& wanted) {
  check_given(wanted.mesh_path, "mesh_path");
  check_given(wanted.store_path, "store_path");
  check_choice("existing", wanted.existing, 3);
  check_choice("durability", wanted.durability, 2);
  SubdivisionRequest request;
  request.mesh = std::filesystem::path(wanted.mesh_path);
  request.store = wanted.store_path;
  request.levels = wanted.levels;
  if (wanted.backend != nullptr) request.backend = wanted.backend;
  if (wanted.layout != nullptr) request.layout = layout_from_name(wanted.layout);
  if (wanted.scheme != nullptr) request.scheme = scheme_from_name(wanted.scheme);
  request.executor = executor_from_name(text_or(wanted.executor, to_string(request.executor)));
  request.precision = precision_of(wanted.precision);
  if (wanted.block_bytes != 0) request.block_bytes = wanted.block_bytes;
  if (wanted.max_slot_bytes != 0) request.max_slot_bytes = wanted.max_slot_bytes;
  if (wanted.budget_bytes != 0) request.budget_bytes = wanted.budget_bytes;
  if (wanted.threads != 0) request.threads = wanted.threads;
  request.parallel_for = parallel_for_by(wanted.parallel_for, wanted.parallel_user);
  request.normals = wanted.normals != 0;
  request.limit = wanted.limit != 0;
  request.verify = wanted.verify != 0;
  request.digest = wanted.digest != 0;
  request.ignore_size = wanted.ignore_size != 0;
  request.weld = weld_of(wanted.weld, wanted.weld_tolerance);
  request.durability =
      wanted.durability == PLAIT_DURABILITY_COMMIT ? Durability::kCommit : Durability::kNone;
  request.existing = static_cast<ExistingStore>(wanted.existing);
  set_pipelines(wanted, request);
  return request;
}
static_assert(static_cast<int>(ExistingStore::kRefuse) == PLAIT_EXISTING_REFUSE);
static_assert(static_cast<int>(ExistingStore::kReplace) == PLAIT_EXISTING_REPLACE);
static_assert(static_cast<int>(ExistingStore::kResume) == PLAIT_EXISTING_RESUME);

plait_subdivision_result result_of(const SubdivisionResult& done) {
  plait_subdivision_result result = PLAIT_SUBDIVISION_RESULT_INIT;
  const LevelCounts& counts = done.plan.level_counts.back();
  result.vertices = counts.vertices;
  result.edges = counts.edges;
  result.faces = counts.faces;
  result.stored_bytes = done.stored_bytes;
  result.import_seconds = done.import_seconds;
  result.layout_seconds = done.layout_seconds;
  result.refine_seconds = done.refine_seconds;
  result.commit_seconds = done.commit_seconds;
  result.digest_seconds = done.digest_seconds;
  result.levels = done.plan.subdivide.levels;
  result.base_level = done.plan.base_level;
  result.resumed_level = done.resumed_level;
  std::memcpy(result.digest, done.digest.c_str(),
              std::min(done.digest.size() + 1, sizeof(result.digest)));
  return result;
}

/// The callbacks of the job. Each step begins with a call that names the step, so that a program
/// can cancel there too: the job stops at the first progress that follows.
SubdivisionWatch watch_by(const plait_subdivision_request& wanted) {
  SubdivisionWatch watch;
  if (wanted.progress != nullptr) {
    const auto cancelled = std::make_shared<bool>(false);
    const ProgressCallback progress = progress_by(wanted.progress, wanted.user);
    watch.step = [=](SubdivisionStep step) {
      *cancelled = *cancelled || !progress({to_string(step), 0, 0});
    };
    watch.progress = [=](const Progress& now) { return !*cancelled && progress(now); };
  }
  watch.warn = warnings_by(wanted.warn, wanted.user);
  return watch;
}

}  // namespace
}  // namespace plait::c

using namespace plait::c;

plait_status plait_job_subdivide(const plait_subdivision_request* request,
                                 plait_subdivision_result* result) {
  return guarded("plait_job_subdivide", [&] {
    check_given(request, "request");
    const plait_subdivision_request wanted =
        options_of(request, plait_subdivision_request PLAIT_SUBDIVISION_REQUEST_INIT,
                   offsetof(plait_subdivision_request, parallel_for));
    if (result != nullptr) check_result(result, "result");
    const plait::BackendRegistry backends = known_backends();  // outlives the job
    plait::SubdivisionJob job(request_of(wanted), backends);
    if (wanted.warn != nullptr)
      for (const std::string& warning : job.plan().warnings)
        wanted.warn(warning.c_str(), wanted.user);
    const plait::SubdivisionResult done = job.run(watch_by(wanted));
    if (result != nullptr) fill(result, result_of(done));
  });
}
