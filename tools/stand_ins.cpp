#include "stand_ins.h"

#include <memory>
#include <set>
#include <utility>

#include "blocks/telling_volume.h"

namespace plait {
BackendRegistry with_warnings(const BackendRegistry& backends,
                              const std::function<void(const std::string&)>& warn) {
  const auto said = std::make_shared<std::set<std::string>>();
  BackendRegistry result;
  for (const std::string& name : backends.names()) {
    RegisteredBackend entry = backends.find(name);
    entry.open = [open = entry.open, said, warn](const VolumeSpec& spec) {
      std::unique_ptr<Volume> volume = open(spec);
      if (const auto* const telling = dynamic_cast<const TellingVolume*>(volume.get()))
        for (const std::string& line : telling->notices())
          if (said->insert(line).second) warn(line);
      return volume;
    };
    result.add(std::move(entry));
  }
  result.set_chooser(backends.chooser());
  return result;
}

}  // namespace plait
