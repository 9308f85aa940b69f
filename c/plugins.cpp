// Plug-ins. The C interface has one set of them for the whole process.
#include "plugins.h"

#include <mutex>

#include "guard.h"
#include "plait.h"
#include "plait/extend/plugins.h"

namespace plait::c {
namespace {

struct Loaded {
  std::mutex mutex;
  Plugins plugins;
};

Loaded& loaded() {
  static Loaded all;
  return all;
}

}  // namespace

BackendRegistry known_backends() {
  Loaded& all = loaded();
  const std::scoped_lock lock(all.mutex);
  return all.plugins.backends();
}

}  // namespace plait::c

plait_status plait_plugin_load(const char* file) {
  return plait::c::guarded("plait_plugin_load", [&] {
    plait::c::check_given(file, "file");
    plait::c::Loaded& all = plait::c::loaded();
    const std::scoped_lock lock(all.mutex);
    all.plugins.load(file);
  });
}
