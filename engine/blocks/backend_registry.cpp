#include "plait/extend/backend_registry.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <utility>

#include "base/text.h"
#include "plait/error.h"
#include "plait/extend/block_maker.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
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

void RegisteredBackend::check_pipelines(const LevelPipelines& pipelines,
                                        const AttributeSchema& schema) const {
  FilterLevel level;
  level.schema = schema;
  pipelines.for_each([&](const Pipeline& pipeline) {
    if (stages)
      stages->open(pipeline, level);
    else if (pipeline != Pipeline())
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("open backend \"{}\": expected pipeline \"none\", found \"{}\"", name,
                              text_for_message(pipeline.to_text())));
  });
}

bool RegisteredBackend::needs_other_blocks(const LevelPipelines& pipelines,
                                           const AttributeSchema& schema) const {
  bool any = false;
  if (stages)
    pipelines.for_each([&](const Pipeline& pipeline) {
      any = any || stages->needs_other_blocks(pipeline, schema);
    });
  return any;
}

Pipeline RegisteredBackend::first_pipeline(const Pipeline& last, const Pipeline& planned,
                                           const AttributeSchema& schema) const {
  if (!needs_other_blocks(last, schema)) return planned;
  Pipeline first = plain_pipeline ? plain_pipeline(schema) : default_pipeline;
  if (planned.recipe && !source_in(*planned.recipe)) first.recipe = planned.recipe;
  return first;
}

LevelPipelines RegisteredBackend::planned(LevelPipelines pipelines,
                                          const PlannedLevels& levels) const {
  if (stages)
    pipelines.for_each([&](Pipeline& pipeline) { pipeline = stages->planned(pipeline, levels); });
  return pipelines;
}

void BackendRegistry::add(RegisteredBackend backend) {
  if (backend.name.empty() || backend.name == kAutomaticBackend || backends_.contains(backend.name))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("add backend \"{}\": expected a name that is free", backend.name));
  if (!backend.open)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("add backend \"{}\": expected a function that opens it", backend.name));
  if (!backend.check_machine) backend.check_machine = [] {};
  const std::string name = backend.name;
  backends_.emplace(name, std::move(backend));
}

const RegisteredBackend& BackendRegistry::find(std::string_view name) const {
  const auto found = backends_.find(name);
  if (found == backends_.end())
    throw Error(ErrorCode::kNotSupported,
                fmt::format("open backend \"{}\": expected one of {}; plug-ins add others "
                            "(--plugin FILE, PLAIT_PLUGINS)",
                            text_for_message(name), fmt::join(names(), ", ")));
  return found->second;
}

BackendChoice BackendRegistry::choose(const NewStore& store) const {
  if (!chooser_)
    throw Error(ErrorCode::kNotSupported,
                fmt::format("choose a backend: these backends have no rule for \"{}\", expected "
                            "one of {}",
                            kAutomaticBackend, fmt::join(names(), ", ")));
  return chooser_(*this, store);
}

std::vector<std::string> BackendRegistry::names() const {
  std::vector<std::string> result;
  for (const auto& [name, backend] : backends_) result.push_back(name);
  return result;
}

PLAIT_END_NAMESPACE
