#include "plait/extend/plugins.h"

#include <algorithm>
#include <utility>

#include "plait/registry.h"
#include "plugins/plugin_file.h"
#include "plugins/registration.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

Plugins::Plugins() : pipelines_(default_pipelines()), backends_(default_backends()) {}

const LoadedPlugin& Plugins::load(const std::filesystem::path& file) {
  const OpenPlugin plugin = open_plugin(file);
  const auto before = std::ranges::find(handles_, plugin.handle);
  if (before != handles_.end()) return loaded_[static_cast<std::size_t>(before - handles_.begin())];

  Registration registration(file, backends_, pipelines_);
  registration.run(plugin.entry);
  // The backends that code blocks keep copies of the codecs, so they are made anew.
  PipelineRegistry pipelines = registration.pipelines();
  BackendRegistry backends = default_backends(pipelines);
  std::vector<RegisteredBackend> own_backends = own_backends_;
  own_backends.insert(own_backends.end(), registration.own_backends().begin(),
                      registration.own_backends().end());
  for (const RegisteredBackend& entry : own_backends) backends.add(entry);

  handles_.reserve(handles_.size() + 1);
  loaded_.push_back(registration.added());
  handles_.push_back(plugin.handle);
  pipelines_ = std::move(pipelines);
  backends_ = std::move(backends);
  own_backends_ = std::move(own_backends);
  return loaded_.back();
}

void Plugins::load_list(std::string_view files) {
  while (!files.empty()) {
    const std::string_view file = files.substr(0, files.find(':'));
    files.remove_prefix(std::min(files.size(), file.size() + 1));
    if (!file.empty()) load(file);
  }
}

PLAIT_END_NAMESPACE
