// A store that many processes make.
#include "plait/extend/parts.h"

#include <fmt/format.h>

#include <string>
#include <utility>

#include "guard.h"
#include "handles.h"
#include "job_options.h"
#include "plait.h"
#include "plait/compression.h"
#include "plugins.h"
#include "sized.h"

namespace plait::c {
namespace {

PartsRequest parts_request_of(const plait_parts_request& wanted) {
  check_given(wanted.mesh_path, "mesh_path");
  check_given(wanted.plan_path, "plan_path");
  check_choice("normals", wanted.normals, 2);
  check_choice("limit", wanted.limit, 2);
  check_reserved(wanted.reserved);
  PartsRequest request;
  request.mesh = wanted.mesh_path;
  request.plan = wanted.plan_path;
  if (wanted.parts != 0) request.parts = wanted.parts;
  request.levels = wanted.levels;
  if (wanted.scheme != nullptr) request.scheme = scheme_from_name(wanted.scheme);
  if (wanted.layout != nullptr) request.layout = layout_from_name(wanted.layout);
  if (wanted.precision != 0) request.precision = static_cast<ComponentType>(wanted.precision);
  request.normals = wanted.normals != 0;
  request.limit = wanted.limit != 0;
  if (wanted.block_bytes != 0) request.block_bytes = wanted.block_bytes;
  if (wanted.max_slot_bytes != 0) request.max_slot_bytes = wanted.max_slot_bytes;
  if (wanted.compress_count != 0)
    request.pipeline_of = [compression = compression_of(wanted.compress, wanted.compress_count)](
                              const AttributeSchema& schema) {
      return compression.pipeline_of(schema);
    };
  return request;
}

PassRequest pass_request_of(const plait_pass_request& wanted) {
  check_given(wanted.store_path, "store_path");
  check_given(wanted.plan_path, "plan_path");
  check_given(wanted.name, "name");
  check_reserved(wanted.reserved);
  PassRequest request;
  request.store = wanted.store_path;
  request.plan = wanted.plan_path;
  if (wanted.budget_bytes != 0) request.budget_bytes = wanted.budget_bytes;
  if (wanted.threads != 0) request.threads = wanted.threads;
  request.progress = progress_by(wanted.progress, wanted.user);
  Pass& pass = request.pass;
  pass.name = wanted.name;
  pass.factor = wanted.factor;
  pass.amplitude = wanted.amplitude;
  pass.seed = wanted.seed;
  if (wanted.diagonal != 0) pass.diagonal = wanted.diagonal;
  if (wanted.result == nullptr) return request;
  if (wanted.components < 1 || wanted.components > 255)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("components: expected 1 to 255, found {}", wanted.components));
  pass.result = {
      wanted.result,
      wanted.type == 0 ? ComponentType::kFloat32 : static_cast<ComponentType>(wanted.type),
      static_cast<std::uint32_t>(wanted.components)};
  pass.parameters = text_or(wanted.parameters, "");
  return request;
}

/// The kernel of a C program as the library calls it. It gets a handle of its own.
PassKernel kernel_by(plait_pass_kernel kernel, void* user) {
  if (kernel == nullptr) return {};
  return [kernel, user](Store& store, const std::string& into, const VisitOptions&) {
    plait_store handle(std::move(store), true);
    const plait_status status = kernel(&handle, into.c_str(), user);
    store = std::move(handle.store);
    if (status != PLAIT_OK) throw_failed("the kernel of the pass", status);
  };
}

}  // namespace
}  // namespace plait::c

using namespace plait::c;

plait_status plait_parts_plan(const plait_parts_request* request) {
  return guarded("plait_parts_plan", [&] {
    check_given(request, "request");
    const plait_parts_request wanted =
        options_of(request, plait_parts_request PLAIT_PARTS_REQUEST_INIT);
    plait::plan_parts(parts_request_of(wanted), known_backends());
  });
}

plait_status plait_pass_plan(const plait_pass_request* request) {
  return guarded("plait_pass_plan", [&] {
    check_given(request, "request");
    const plait_pass_request wanted =
        options_of(request, plait_pass_request PLAIT_PASS_REQUEST_INIT);
    plait::plan_pass(pass_request_of(wanted), known_backends());
  });
}

plait_status plait_parts_make(const char* plan_path, uint32_t part,
                              const plait_part_options* options) {
  return guarded("plait_parts_make", [&] {
    check_given(plan_path, "plan_path");
    const plait_part_options wanted =
        options_of(options, plait_part_options PLAIT_PART_OPTIONS_INIT);
    check_choice("again", wanted.again, 2);
    plait::PartOptions how;
    if (wanted.budget_bytes != 0) how.budget_bytes = wanted.budget_bytes;
    if (wanted.threads != 0) how.threads = wanted.threads;
    how.again = wanted.again != 0;
    how.progress = progress_by(wanted.progress, wanted.user);
    how.kernel = kernel_by(wanted.kernel, wanted.kernel_user);
    plait::make_part(plan_path, part, how, known_backends());
  });
}

plait_status plait_parts_join(const char* plan_path, const char* store_path,
                              const plait_join_options* options) {
  return guarded("plait_parts_join", [&] {
    check_given(plan_path, "plan_path");
    check_given(store_path, "store_path");
    const plait_join_options wanted =
        options_of(options, plait_join_options PLAIT_JOIN_OPTIONS_INIT);
    check_choice("verify", wanted.verify, 2);
    check_choice("concat", wanted.concat, 2);
    check_choice("existing", wanted.existing, 2);
    check_reserved(wanted.reserved);
    plait::JoinOptions how;
    if (wanted.budget_bytes != 0) how.budget_bytes = wanted.budget_bytes;
    how.verify = wanted.verify != 0;
    how.concat = wanted.concat != 0;
    how.replace = wanted.existing == PLAIT_EXISTING_REPLACE;
    how.progress = progress_by(wanted.progress, wanted.user);
    const plait::JoinResult joined =
        plait::join_parts(plan_path, store_path, how, known_backends());
    if (!joined.has_store)
      throw plait::Error(
          plait::ErrorCode::kBadState,
          fmt::format("join {}: parts {} are missing or damaged", plan_path, joined.again()));
  });
}
