// Views: the records of one patch.
#include <cstddef>
#include <span>

#include "guard.h"
#include "handles.h"
#include "plait.h"
#include "plait/reader.h"
#include "sized.h"

namespace plait::c {
namespace {

const PatchView& patch_of(const plait_view* handle) {
  check_given(handle, "view");
  return *handle->patch;
}

}  // namespace
}  // namespace plait::c

using namespace plait::c;

plait_status plait_view_get_info(const plait_view* view, plait_view_info* info) {
  return guarded("plait_view_get_info", [&] {
    const plait::PatchView& patch = patch_of(view);
    check_result(info, "info");
    fill(info, plait_view_info{sizeof(plait_view_info), plait::patch_vertex_count(patch.size()),
                               patch.size(), patch.face(), patch.level()});
  });
}

plait_status plait_view_at(const plait_view* view, const char* name, int64_t i, int64_t j,
                           const void** record) {
  return guarded("plait_view_at", [&] {
    const plait::PatchView& patch = patch_of(view);
    check_given(name, "name");
    check_given(record, "record");
    *record = patch.records(name).at(i, j).data();
  });
}

plait_status plait_view_copy(const plait_view* view, const char* name, void* records,
                             uint64_t bytes) {
  return guarded("plait_view_copy", [&] {
    const plait::PatchView& patch = patch_of(view);
    check_given(name, "name");
    check_given(records, "records");
    patch.records(name).copy_to({static_cast<std::byte*>(records), bytes});
  });
}

void plait_view_release(plait_view* view) { delete view; }
