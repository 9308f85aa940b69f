#include <fmt/format.h>
#include <fmt/ranges.h>

#include <utility>

#include "plait/backend.h"
#include "plait/error.h"

namespace plait {
namespace {

class SeparateLevels final : public Volume {
 public:
  explicit SeparateLevels(OpenLevel open) : open_(std::move(open)) {}
  std::unique_ptr<Backend> open_level(const LevelSpec& level) override { return open_(level); }

 private:
  OpenLevel open_;
};

}  // namespace

OpenVolume open_each_level(OpenLevel open) {
  return [open = std::move(open)](const VolumeSpec&) {
    return std::make_unique<SeparateLevels>(open);
  };
}

void BackendRegistry::add(Entry entry) {
  if (entry.name.empty() || entries_.contains(entry.name))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("add backend \"{}\": expected a name that is free", entry.name));
  if (!entry.open)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("add backend \"{}\": expected a function that opens it", entry.name));
  if (!entry.validate) entry.validate = [](const BackendOptions&) {};
  Entry& added = entries_[entry.name];
  added = std::move(entry);
}

const BackendRegistry::Entry& BackendRegistry::find(std::string_view name) const {
  const auto found = entries_.find(name);
  if (found == entries_.end())
    throw Error(ErrorCode::kNotSupported, fmt::format("open backend \"{}\": expected one of {}",
                                                      name, fmt::join(names(), ", ")));
  return found->second;
}

std::vector<std::string> BackendRegistry::names() const {
  std::vector<std::string> result;
  for (const auto& [name, entry] : entries_) result.push_back(name);
  return result;
}

}  // namespace plait
