// Parts of a pass of the program's own.
#include "plait/extend/parts.h"

#include <string>
#include <utility>

#include "guard.h"
#include "handles.h"
#include "plait.h"
#include "plugins.h"
#include "sized.h"

namespace plait::c {
namespace {

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
    if (wanted.store != nullptr) how.store = wanted.store;
    plait::make_part(plan_path, part, how, known_backends());
  });
}
