// plait/extend/plugins.h: loads plug-ins, and has their backends, codecs and filters beside the
// built-in ones. docs/plugins.md explains how to write one.
#pragma once

#include <deque>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/extend/backend_registry.h"
#include "plait/extend/pipeline_registry.h"

PLAIT_BEGIN_NAMESPACE

/// A plug-in, and the names that it added.
struct LoadedPlugin {
  std::filesystem::path file;  ///< as it was given to Plugins::load()
  std::vector<std::string> backends, codecs, filters;
};

/// The registries that a program opens stores with, once it has loaded its plug-ins:
///
///   plait::Plugins plugins;
///   plugins.load("./libmine.so");
///   auto store = plait::Store::open("surface.plait", {}, plugins.backends());
///
/// The code of a plug-in stays in the process until it ends, also if the plug-in was refused. While
/// a thread is in load() or load_list(), no other thread may use the object.
class Plugins {
 public:
  /// The built-in backends, codecs and filters.
  Plugins();

  /// Loads the shared library `file` and adds what it has. A name without '/' is a file of the
  /// working directory. A plug-in that this object has loaded before is returned as it is. The
  /// plug-in runs as a part of this process, so load only files that you trust.
  /// Errors, after which nothing was added: kNotFound; kInvalidArgument for a file that is no
  /// shared library or no plug-in, and for a plug-in that adds a name that is taken; kNotSupported
  /// for a plug-in of another version of plait, and for one that says that it cannot be used.
  const LoadedPlugin& load(const std::filesystem::path& file);
  /// Loads each file of a list with ':' between the names, as PLAIT_PLUGINS has it. Skips empty
  /// names. Errors: as load(); plug-ins before the one that failed stay.
  void load_list(std::string_view files);

  /// In the order of loading. References stay valid.
  const std::deque<LoadedPlugin>& loaded() const { return loaded_; }
  /// The built-in backends and those of the plug-ins; `compressed` has the codecs and filters of
  /// all plug-ins. The reference stays valid; the next load() changes the registry.
  const BackendRegistry& backends() const { return backends_; }
  const PipelineRegistry& pipelines() const { return pipelines_; }

 private:
  std::vector<void*> handles_;  ///< of dlopen, in the order of loaded_
  std::deque<LoadedPlugin> loaded_;
  std::vector<RegisteredBackend> own_backends_;  ///< of all plug-ins
  PipelineRegistry pipelines_;
  BackendRegistry backends_;
};

PLAIT_END_NAMESPACE
