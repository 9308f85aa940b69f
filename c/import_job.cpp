// The job that makes a store of a mesh that is semi-regular already.
#include <fmt/format.h>

#include "guard.h"
#include "handles.h"
#include "job_options.h"
#include "plait.h"
#include "plait/extend/import_mesh.h"
#include "plugins.h"
#include "sized.h"

namespace plait::c {
namespace {

ImportRequest import_request_of(const plait_import_request& wanted) {
  check_given(wanted.mesh_path, "mesh_path");
  check_given(wanted.store_path, "store_path");
  check_choice("existing", wanted.existing, 2);
  check_choice("durability", wanted.durability, 2);
  ImportRequest request;
  request.mesh = wanted.mesh_path;
  request.store = wanted.store_path;
  if (wanted.levels != 0) request.levels = wanted.levels;
  request.backend = text_or(wanted.backend, request.backend);
  if (wanted.layout != nullptr) request.layout = layout_from_name(wanted.layout);
  if (wanted.compress_count > 0)
    request.pipeline_of = [compression = compression_of(wanted.compress, wanted.compress_count)](
                              const AttributeSchema& schema) {
      return compression.pipeline_of(schema);
    };
  request.precision = precision_of(wanted.precision);
  if (wanted.block_bytes != 0) request.block_bytes = wanted.block_bytes;
  if (wanted.max_slot_bytes != 0) request.max_slot_bytes = wanted.max_slot_bytes;
  if (wanted.budget_bytes != 0) request.budget_bytes = wanted.budget_bytes;
  if (wanted.threads != 0) request.threads = wanted.threads;
  request.durability =
      wanted.durability == PLAIT_DURABILITY_COMMIT ? Durability::kCommit : Durability::kNone;
  request.replace = wanted.existing == PLAIT_EXISTING_REPLACE;
  request.ignore_size = wanted.ignore_size != 0;
  request.weld = weld_of(wanted.weld, wanted.weld_tolerance);
  return request;
}

plait_import_result import_result_of(const ImportResult& done) {
  plait_import_result result = PLAIT_IMPORT_RESULT_INIT;
  result.vertices = done.vertices;
  result.faces = done.faces;
  result.base_vertices = done.base_vertices;
  result.base_faces = done.base_faces;
  result.border_edges = done.border_edges;
  result.stored_bytes = done.stored_bytes;
  result.read_seconds = done.read_seconds;
  result.recover_seconds = done.recover_seconds;
  result.write_seconds = done.write_seconds;
  result.levels = done.levels;
  result.base_level = done.base_level;
  result.had_choice = done.had_choice ? 1 : 0;
  return result;
}

}  // namespace
}  // namespace plait::c

using namespace plait::c;

plait_status plait_job_import(const plait_import_request* request, plait_import_result* result) {
  return guarded("plait_job_import", [&] {
    check_given(request, "request");
    const plait_import_request wanted =
        options_of(request, plait_import_request PLAIT_IMPORT_REQUEST_INIT);
    if (result != nullptr) check_result(result, "result");
    plait::ImportWatch watch;
    if (wanted.progress != nullptr) watch.progress = progress_by(wanted.progress, wanted.user);
    watch.warn = warnings_by(wanted.warn, wanted.user);
    const plait::ImportResult done =
        plait::import_mesh(import_request_of(wanted), known_backends(), watch);
    if (result != nullptr) fill(result, import_result_of(done));
  });
}
