// Work on a whole store: subdivide, digest, bounds, verify.
#include <cstring>
#include <string>
#include <vector>

#include "guard.h"
#include "handles.h"
#include "mesh/narrowing.h"
#include "plait.h"
#include "plait/bounds.h"
#include "plait/digest.h"
#include "plait/subdivide.h"
#include "plait/verify.h"
#include "sized.h"

namespace plait::c {
namespace {

SubdivideOptions subdivide_options(Store& store, const plait_subdivide_options& wanted) {
  check_reserved(wanted.reserved);
  check_choice("normals", wanted.normals, 2);
  check_choice("limit", wanted.limit, 2);
  check_choice("commit_levels", wanted.commit_levels, 2);
  SubdivideOptions options;
  options.scheme = scheme_from_name(text_or(wanted.scheme, to_string(options.scheme)));
  options.executor = executor_from_name(text_or(wanted.executor, to_string(options.executor)));
  options.levels = wanted.levels;
  options.normals = wanted.normals != 0;
  options.limit = wanted.limit != 0;
  options.threads = wanted.threads;
  options.progress = progress_by(wanted.progress, wanted.user);
  if (wanted.commit_levels != 0) {
    if (options.executor == ExecutorKind::kFused)
      throw Error(ErrorCode::kInvalidArgument,
                  "commit_levels: expected 0 with executor fused, which finishes all levels at "
                  "once");
    options.level_done = [&store](int) { store.commit(); };
  }
  return options;
}

void warn_of_coarse_type(const Store& store, const plait_subdivide_options& wanted) {
  if (!store.has_attribute("position") || wanted.levels <= store.base_level()) return;
  std::vector<std::string> warnings;
  precision_for(store.base().positions(), store.base().faces(), wanted.levels - store.base_level(),
                store.attributes()[store.attribute("position")].schema.type, "subdivide", warnings);
  for (const std::string& warning : warnings) wanted.warn(warning.c_str(), wanted.user);
}

}  // namespace

ProgressCallback progress_by(plait_progress progress, void* user) {
  if (progress == nullptr) return {};
  return [=](const Progress& now) {
    const std::string phase(now.phase);
    return progress(phase.c_str(), now.done, now.total, user) != 0;
  };
}

}  // namespace plait::c

using namespace plait::c;

plait_status plait_store_subdivide(plait_store* store, const plait_subdivide_options* options) {
  return guarded("plait_store_subdivide", [&] {
    plait::Store& changed = changed_store(store);
    const plait_subdivide_options wanted =
        options_of(options, plait_subdivide_options PLAIT_SUBDIVIDE_OPTIONS_INIT);
    const plait::SubdivideOptions how = subdivide_options(changed, wanted);
    if (wanted.warn != nullptr) warn_of_coarse_type(changed, wanted);
    plait::subdivide(changed, how);
  });
}

plait_status plait_store_digest(plait_store* store, int32_t level, int32_t threads,
                                plait_progress progress, void* user,
                                char text[PLAIT_DIGEST_BYTES]) {
  return guarded("plait_store_digest", [&] {
    check_given(store, "store");
    check_given(text, "text");
    const std::string digits =
        plait::digest(store->store,
                      {.level = level, .threads = threads, .progress = progress_by(progress, user)})
            .to_string();
    std::memcpy(text, digits.c_str(), PLAIT_DIGEST_BYTES);
  });
}

plait_status plait_store_write_bounds(plait_store* store, const char* attribute,
                                      plait_progress progress, void* user) {
  return guarded("plait_store_write_bounds", [&] {
    check_given(store, "store");
    plait::write_bounds(store->store, text_or(attribute, "position"), progress_by(progress, user));
  });
}

plait_status plait_store_verify(plait_store* store, plait_progress progress, plait_damage damage,
                                void* user, plait_verify_report* report) {
  return guarded("plait_store_verify", [&] {
    check_given(store, "store");
    if (report != nullptr) check_result(report, "report");
    const plait::VerifyReport found = plait::verify(store->store, progress_by(progress, user));
    if (damage != nullptr)
      for (const plait::DamagedBlock& block : found.damaged) {
        const plait_damaged_block told = {sizeof(told),
                                          block.attribute.c_str(),
                                          block.reason.c_str(),
                                          block.block,
                                          block.file_offset,
                                          block.first_edge,
                                          block.edge_after,
                                          block.level,
                                          0};
        damage(&told, user);
      }
    if (report != nullptr)
      fill(report, plait_verify_report{sizeof(plait_verify_report), found.blocks, found.bytes,
                                       found.never_written, found.damaged_count});
  });
}
