// backends/plugins/plugin_file.h: the file of a plug-in, and its function.
#pragma once

#include <filesystem>

#include "plait/detail/namespace.h"
#include "plait/extend/plugin.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

using PluginFunction = std::int32_t (*)(const plait_host*);

/// A shared library in the process.
struct OpenPlugin {
  void* handle = nullptr;  ///< of dlopen; the same for each time that the library is opened
  PluginFunction entry = nullptr;
};

/// Opens the shared library for good. Errors: kNotFound; kInvalidArgument for anything but a shared
/// library with the function plait_plugin_v1. The message names the file, but has no verb.
OpenPlugin open_plugin(const std::filesystem::path& path);

PLAIT_END_NAMESPACE
