// plugins.h: the backends with which the C interface makes and opens stores.
#pragma once

#include "plait/extend/backend_registry.h"

namespace plait::c {

/// The built-in backends and those of the plug-ins that plait_plugin_load() has loaded by now.
/// Safe from any thread.
BackendRegistry known_backends();

}  // namespace plait::c
