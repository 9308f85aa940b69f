// backends/plugins/registration.h: what one plug-in adds, until all of it is accepted.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/extend/plugin_in_cpp.h"
#include "plait/extend/plugins.h"
#include "plugins/plugin_file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Copies of the registries, to which one plug-in adds. The caller drops them if the plug-in is
/// refused, so nothing half-registered stays.
class Registration final : public PluginRegistry {
 public:
  Registration(const std::filesystem::path& file, const BackendRegistry& backends,
               const PipelineRegistry& pipelines);
  Registration(const Registration&) = delete;  // host_ has its address
  Registration& operator=(const Registration&) = delete;

  /// Calls the function of the plug-in. Errors, with the name of the file: kInvalidArgument for a
  /// refused addition, kNotSupported for a plug-in that cannot be used here.
  void run(PluginFunction entry);

  void add(RegisteredBackend entry) override;
  void add(RegisteredCodec entry) override;
  void add(RegisteredFilter entry) override;

  const LoadedPlugin& added() const { return added_; }
  const PipelineRegistry& pipelines() const { return pipelines_; }
  const std::vector<RegisteredBackend>& own_backends() const { return own_backends_; }

 private:
  static std::int32_t add_codec(const plait_host* host, const plait_codec* codec) noexcept;
  static std::int32_t add_filter(const plait_host* host, const plait_filter* filter) noexcept;
  static void refuse(const plait_host* host, const char* reason) noexcept;
  static void* cpp_registry(const plait_host* host, const char* stamp) noexcept;

  /// Runs `addition` and keeps its error, because a plug-in may ignore it.
  template <class Addition>
  void keep_error(const Addition& addition);
  /// Keeps the first reason.
  void fail(ErrorCode code, std::string_view reason);

  plait_host host_;
  BackendRegistry backends_;
  PipelineRegistry pipelines_;
  std::vector<RegisteredBackend> own_backends_;
  LoadedPlugin added_;
  bool failed_ = false;
  ErrorCode code_ = ErrorCode::kInvalidArgument;
  std::string reason_;
};

PLAIT_END_NAMESPACE
