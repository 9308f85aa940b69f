#include "conversion/conversion_job.h"

#include <fmt/format.h>

#include <map>
#include <utility>

#include "conversion/copy_options.h"
#include "conversion/read_back.h"
#include "conversion/uniform_levels.h"
#include "maintenance/decoded_again.h"
#include "maintenance/read_block.h"
#include "plait/extend/copy_levels.h"
#include "plait/extend/notices.h"
#include "plait/extend/pager.h"
#include "plait/extend/store_access.h"
#include "plait/store.h"
#include "plait/store_info.h"
#include "store/attribute_levels.h"
#include "store/new_output.h"
#include "store/store_uuid.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

BackendChoice backend_of_copy(const ConversionRequest& request, const CopyChoices& choices,
                              const Store& source, const BackendRegistry& backends) {
  if (!request.max_errors.empty() && choices.backend.empty() && !choices.compresses &&
      !source.info().backend.compressed)
    return {"compressed", "because of the rounding"};
  return choose_backend_of_copy(choices, source, backends);
}

/// The pipelines of the copy, with the steps of the attributes that are rounded.
PipelinesOf with_steps(const PipelinesOf& pipeline_of, const ErrorBounds& bounds,
                       const Store& source) {
  std::map<std::string, double> steps;
  for (const auto& [name, bound] : bounds.all()) {
    const AttributeId id = source.attribute(name);
    steps[name] = Rounder(source.attributes()[id].schema, bound, source.base_bytes(id)).step();
  }
  return [=](const AttributeSchema& schema) {
    const LevelPipelines pipelines = pipeline_of(schema);
    const auto step = steps.find(schema.name);
    return step == steps.end() ? pipelines : pipeline_of_rounded(pipelines, step->second);
  };
}

/// Sets the options of the copy, and why it has its backend.
void choose_options(const ConversionRequest& request, const Store& source,
                    const BackendRegistry& backends, ConversionResult& result) {
  const CopyChoices choices{request.from,        request.to,
                            request.backend,     !request.compression.empty(),
                            request.block_bytes, request.budget_bytes};
  StoreOptions& options = result.options = source.options();
  BackendChoice choice = backend_of_copy(request, choices, source, backends);
  options.backend = choice.name;
  result.backend_reason = std::move(choice.reason);
  const RegisteredBackend& backend =
      find_backend_of_copy(choices, options.backend, request.verb, backends);
  const bool stays_compressed = source.info().backend.compressed && backend.traits.compressed;
  if (!stays_compressed) options.pipeline = backend.default_pipeline;
  if ((choices.compresses && backend.traits.compressed) ||
      (!request.max_errors.empty() && !stays_compressed && backend.traits.compressed)) {
    request.compression.check_levels(source.base_level(), source.finest_level());
    std::vector<std::string> names = request.attributes_of_change;
    for (const AttributeInfo& info : source.attributes()) names.push_back(info.schema.name);
    request.compression.check_attributes(names);
    options.pipeline_of = [compression = request.compression](const AttributeSchema& schema) {
      return compression.pipeline_of(schema);
    };
  } else if (stays_compressed) {
    options.pipeline_of = [&source](const AttributeSchema& schema) {
      return pipelines_of_levels(source, source.attribute(schema.name));
    };
  }
  if (!request.max_errors.empty() && options.pipeline_of)
    options.pipeline_of = with_steps(options.pipeline_of, request.max_errors, source);
  for (const AttributeInfo& info : source.attributes())
    backend.check_pipelines(
        options.pipeline_of ? options.pipeline_of(info.schema) : *options.pipeline, info.schema);
  set_common_options(choices, source, backend.traits, options);
  options.parallel_for = request.parallel_for;
  options.base_index = std::nullopt;
  if (request.no_index) options.base_index = false;
}

BaseMesh base_of_copy(const ConversionRequest& request, Store& source) {
  if (request.base) return request.base(source);
  return request.uniform ? source.base().without_depths() : source.base();
}

}  // namespace

std::uint64_t vertices_of(const Store& store) {
  std::uint64_t vertices = store.base().vertex_count();
  for (int level = store.base_level() + 1; level <= store.finest_level(); ++level)
    vertices += StoreAccess::geometry(store, 1, level).total_bytes();
  return vertices;
}

ConversionResult convert(const ConversionRequest& request, const BackendRegistry& source_backends,
                         const BackendRegistry& backends, const JobWatch& watch) {
  if (request.budget_bytes < 2 * kLeastBudgetBytes)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{} {}: memory {} bytes: expected at least {}, half for each store",
                            request.verb, request.from.native(), request.budget_bytes,
                            2 * kLeastBudgetBytes));
  OpenOptions open;
  open.budget_bytes = request.budget_bytes / 2;
  open.parallel_for = request.parallel_for;
  if (request.uniform && !request.max_errors.empty())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("convert {}: depth uniform and max-error in one step: expected one of "
                            "them, then the other on the copy",
                            request.from.native()));
  Store source = Store::open(request.from, open, source_backends);
  ConversionResult result;
  choose_options(request, source, backends, result);
  if (watch.before_files) watch.before_files();
  tell_notices(source, watch.warn);
  const auto make = [&](const std::filesystem::path& path) {
    result.from_stored_bytes = source.info().stored_bytes;
    result.from_backend = source.options().backend;
    const bool fills = request.uniform && source.has_depths();
    const BaseMesh base = base_of_copy(request, source);
    // The copy has the budget that the source can do without.
    const LentMemory to_copy(StoreAccess::pager(source), fills ? 0 : spare_source_bytes(source));
    result.options.budget_bytes += to_copy.bytes();
    Store copy = Store::create(path, base, result.options, backends, source.provenance());
    if (request.uuid) set_uuid(copy, *request.uuid);
    tell_notices(copy, watch.warn, request.to);
    const bool changes_later = static_cast<bool>(request.change);
    const ProgressCallback progress = begin_step(watch, changes_later ? "copy" : "convert");
    if (fills)
      fill_levels(source, copy, progress);
    else
      copy_levels(source, copy, progress, request.max_errors, changes_later);
    if (const std::string again = decoded_again(source); !again.empty() && watch.warn)
      watch.warn(again);
    if (changes_later) request.change(copy);
    if (changes_later || fills) copy.finish_encoding(begin_step(watch, "encode"));
    for (const auto& [name, bound] : request.max_errors.all())
      result.roundings[name] = *StoreAccess::rounding(copy, copy.attribute(name));
    copy.commit();
    result.stored_bytes = copy.info().stored_bytes;
    result.vertices = vertices_of(copy);
    if (fills) {
      result.filled_vertices = result.vertices - vertices_of(source);
      for (AttributeId id = 0; id < source.attributes().size(); ++id)
        if (const std::optional<Rounding>& rounding = StoreAccess::rounding(source, id))
          result.left_out_roundings[source.attributes()[id].schema.name] = *rounding;
    }
    copy.close();
    if (request.finish) request.finish(path);
    if (request.verify && fills)
      result.digest = compare_filled_copy(source, path, open, request.threads, backends, watch);
    else if (request.verify)
      result.digest = request.max_errors.empty()
                          ? compare_copy(source, path, open, request.threads, backends, watch)
                          : compare_rounded_copy(source, path, open, request.threads, backends,
                                                 request.max_errors, watch);
    if (const ProgressCallback go_on = begin_step(watch, "publish"); go_on && !go_on({{}, 0, 1}))
      throw Error(ErrorCode::kCancelled, fmt::format("{}: cancelled", request.verb));
  };
  result.store =
      make_new_store(request.to, request.existing, Durability::kCommit, watch.warn, make);
  result.options.pipeline_of = {};  // it may refer to the source
  return result;
}

PLAIT_END_NAMESPACE
