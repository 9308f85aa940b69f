#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "plait/backend.h"
#include "plait/error.h"
#include "plait/level_pipelines.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The most characters of a specification in a message, because a message is one line.
constexpr std::size_t kMostNamed = 100;

class SeparateLevels final : public Volume {
 public:
  explicit SeparateLevels(OpenLevel open) : open_(std::move(open)) {}
  std::unique_ptr<Backend> open_level(const LevelSpec& level) override { return open_(level); }

 private:
  OpenLevel open_;
};

/// Lets the functions of a backend, which know one pipeline, take the pipelines of an attribute.
void take_pipelines_of_levels(BackendRegistry::Entry& entry) {
  entry.validate_pipeline = [one = std::move(entry.validate_pipeline)](
                                std::string_view text, const AttributeSchema& schema) {
    for (const std::string& pipeline : LevelPipelines::parse(text).all()) one(pipeline, schema);
  };
  entry.needs_other_blocks = [one = std::move(entry.needs_other_blocks)](
                                 std::string_view text, const AttributeSchema& schema) {
    return std::ranges::any_of(LevelPipelines::parse(text).all(),
                               [&](const std::string& pipeline) { return one(pipeline, schema); });
  };
  entry.plan_pipeline = [one = std::move(entry.plan_pipeline)](
                            std::string_view text, const Provenance& provenance,
                            const AttributeSchema& schema, int finest_level) {
    return LevelPipelines::parse(text)
        .changed([&](std::string_view pipeline) {
          return one(pipeline, provenance, schema, finest_level);
        })
        .to_text();
  };
}

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
  if (!entry.validate)
    entry.validate = [name = entry.name](std::string_view options) {
      if (!options.empty())
        throw Error(ErrorCode::kInvalidArgument,
                    fmt::format("open backend \"{}\": expected no options, found \"{}\"", name,
                                options.substr(0, kMostNamed)));
    };
  if (!entry.validate_pipeline)
    entry.validate_pipeline = [name = entry.name](std::string_view pipeline,
                                                  const AttributeSchema&) {
      if (pipeline != "none")
        throw Error(ErrorCode::kInvalidArgument,
                    fmt::format("open backend \"{}\": expected pipeline \"none\", found \"{}\"",
                                name, pipeline.substr(0, kMostNamed)));
    };
  if (!entry.needs_other_blocks)
    entry.needs_other_blocks = [](std::string_view, const AttributeSchema&) { return false; };
  if (!entry.plan_pipeline)
    entry.plan_pipeline = [](std::string_view pipeline, const Provenance&, const AttributeSchema&,
                             int) { return std::string(pipeline); };
  take_pipelines_of_levels(entry);
  Entry& added = entries_[entry.name];
  added = std::move(entry);
}

const BackendRegistry::Entry& BackendRegistry::find(std::string_view specification) const {
  const std::string_view name = specification.substr(0, specification.find(':'));
  const auto found = entries_.find(name);
  if (found == entries_.end())
    throw Error(ErrorCode::kNotSupported,
                fmt::format("open backend \"{}\": expected one of {}; plug-ins add others "
                            "(--plugin FILE, PLAIT_PLUGINS)",
                            name.substr(0, kMostNamed), fmt::join(names(), ", ")));
  return found->second;
}

std::string_view BackendRegistry::options_in(std::string_view specification) {
  const std::size_t colon = specification.find(':');
  return colon == std::string_view::npos ? std::string_view() : specification.substr(colon + 1);
}

std::vector<std::string> BackendRegistry::names() const {
  std::vector<std::string> result;
  for (const auto& [name, entry] : entries_) result.push_back(name);
  return result;
}

PLAIT_END_NAMESPACE
