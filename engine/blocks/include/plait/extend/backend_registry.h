// plait/extend/backend_registry.h: the backends that a program has, by name, and the choice of one
// for a new store.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "plait/attribute.h"
#include "plait/detail/namespace.h"
#include "plait/extend/backend.h"
#include "plait/extend/pipeline_registry.h"

PLAIT_BEGIN_NAMESPACE

/// The name that stands for the backend which BackendRegistry::choose() chooses.
inline constexpr std::string_view kAutomaticBackend = "auto";

/// What the choice of a backend for a new store depends on.
struct NewStore {
  std::filesystem::path path = {};  ///< empty: the store is only in memory
  /// Of all levels that it will have, before compression. 0: not known, or few.
  std::uint64_t level_bytes = 0;
  bool has_pipelines = false;  ///< the caller names pipelines, so the backend must compress
  /// Memory that the store's files can use; not set: what the machine has available.
  std::optional<std::uint64_t> available_bytes = {};
};

/// The backend that BackendRegistry::choose() chose.
struct BackendChoice {
  std::string name;
  std::string reason;  ///< one clause: sizes, or why another one cannot be used
};

/// A backend: its name, its properties, and the function that opens it.
struct RegisteredBackend {
  std::string name = {};
  std::string summary = {};  ///< one line for --help
  BackendTraits traits = {};
  OpenVolume open = {};
  /// Throws kNotSupported if this machine cannot use the backend. A store calls it before it makes
  /// or opens a level. Empty: every machine can.
  std::function<void()> check_machine = {};
  /// The pipeline of a store that names none.
  Pipeline default_pipeline = {};
  /// The best pipeline for such records that needs no other blocks. Empty: the default.
  std::function<Pipeline(const AttributeSchema&)> plain_pipeline = {};
  /// The filters and codecs that the backend uses. nullptr: its only pipeline is "none".
  std::shared_ptr<const PipelineRegistry> stages = {};

  /// Throws kInvalidArgument or kNotSupported for a pipeline that the backend cannot use for
  /// records of this type.
  void check_pipelines(const LevelPipelines& pipelines, const AttributeSchema& schema) const;
  /// As PipelineRegistry::needs_other_blocks(), for any of the levels.
  bool needs_other_blocks(const LevelPipelines& pipelines, const AttributeSchema& schema) const;
  /// What a pass that writes blocks in any order can take for levels that get the pipeline `last`:
  /// `planned`, which is `last` with a recipe, if blocks of `last` need no others. Else a plain
  /// pipeline, with the recipe if it is made from the base mesh.
  Pipeline first_pipeline(const Pipeline& last, const Pipeline& planned,
                          const AttributeSchema& schema) const;
  /// As PipelineRegistry::planned().
  LevelPipelines planned(LevelPipelines pipelines, const PlannedLevels& levels) const;
};

/// Finds backends by name. The engine contains no backend. plait::default_backends() has the
/// built-in ones, and a program may add its own.
class BackendRegistry {
 public:
  using Chooser = std::function<BackendChoice(const BackendRegistry&, const NewStore&)>;

  /// Errors: kInvalidArgument if the name is taken, empty or "auto", or if `open` is empty.
  void add(RegisteredBackend backend);
  /// Errors: kNotSupported for an unknown name; the message lists the known ones.
  const RegisteredBackend& find(std::string_view name) const;
  std::vector<std::string> names() const;
  /// Chooses the backend of a store whose options name "auto", by the function of set_chooser().
  /// Errors: kNotSupported if the registry has none.
  BackendChoice choose(const NewStore& store) const;
  const Chooser& chooser() const noexcept { return chooser_; }
  void set_chooser(Chooser chooser) { chooser_ = std::move(chooser); }

 private:
  std::map<std::string, RegisteredBackend, std::less<>> backends_;
  Chooser chooser_;
};

PLAIT_END_NAMESPACE
