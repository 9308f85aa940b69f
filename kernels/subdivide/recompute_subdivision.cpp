#include "plait/kernels/recompute_subdivision.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "plait/error.h"
#include "plait/fused.h"
#include "plait/kernels/subdivide.h"
#include "schemes/table.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

const AttributeInfo* find(const StoreCheck& check, std::string_view name) {
  const auto found = std::ranges::find_if(check.attributes, [&](const AttributeInfo& info) {
    return info.schema.name == name && info.schema.components == 3;
  });
  return found == check.attributes.end() ? nullptr : &*found;
}

bool is_real(ComponentType type) {
  return type == ComponentType::kFloat32 || type == ComponentType::kFloat64;
}

/// Sets the scheme of `options`, or returns why there is no scheme of this name.
std::string choose_scheme(const std::string& name, const std::vector<OneRingScheme>& own_schemes,
                          SubdivideOptions& options) {
  const auto own = std::ranges::find(own_schemes, name, &OneRingScheme::name);
  if (own != own_schemes.end()) {
    options.own_scheme = &*own;
    return {};
  }
  if (name.empty()) return "the manifest does not say what made the levels";
  try {
    options.scheme = scheme_from_name(name);
    return {};
  } catch (const Error&) {
    return fmt::format("the manifest's scheme '{}' is none that can be repeated", name);
  }
}

std::uint64_t level_bytes(const StoreCheck& check, const SubdivideOptions& options,
                          std::size_t position_bytes) {
  // The sweep has limit positions in addition to the positions until it ends.
  const std::size_t records =
      position_bytes + (options.normals ? 3 * sizeof(float) : 0) +
      (options.limit && options.executor == ExecutorKind::kSweep ? position_bytes : 0);
  std::uint64_t bytes = 0;
  const BaseRelativeLevel finest = relative_to_base(options.levels, check.options.base_level);
  for (int level = 1; level <= finest.refinements; ++level)
    bytes += LevelGeometry(check.base.slot_shapes(), BaseRelativeLevel(level), records,
                           check.options.block_bytes)
                 .total_bytes();
  return bytes;
}

Recomputation no_recomputation(const std::string& reason) {
  Recomputation refused;
  refused.refusal = [reason](std::string_view attribute) {
    return attribute == "position"
               ? reason
               : fmt::format("attribute '{}' does not follow from the base mesh", attribute);
  };
  return refused;
}

Recomputation plan(const StoreCheck& check,
                   const std::shared_ptr<const std::vector<OneRingScheme>>& own_schemes) {
  const AttributeInfo* const position = find(check, "position");
  if (position == nullptr || !is_real(position->schema.type))
    return no_recomputation("the store has no positions of a refinement");
  SubdivideOptions options;
  if (const std::string reason = choose_scheme(check.provenance.scheme, *own_schemes, options);
      !reason.empty())
    return no_recomputation(reason);
  options.limit = check.provenance.limit;
  if (options.limit && !traits_of(options).has_limits)
    return no_recomputation(
        fmt::format("the manifest's scheme '{}' has no limit positions", check.provenance.scheme));
  const int levels = relative_to_base(position->finest_level, check.options.base_level).refinements;
  const bool fused = levels >= 1 && levels <= kMostFusedLevels;
  options.executor = fused ? ExecutorKind::kFused : ExecutorKind::kSweep;
  options.levels = position->finest_level;
  const AttributeInfo* const normal = find(check, "normal");
  options.normals = normal != nullptr && normal->schema.type == ComponentType::kFloat32 &&
                    normal->finest_level == position->finest_level;

  Recomputation result;
  result.refusal = [has_normals = options.normals](std::string_view attribute) {
    return attribute == "position" || (attribute == "normal" && has_normals)
               ? std::string()
               : fmt::format("attribute '{}' does not follow from the base mesh", attribute);
  };
  result.level_bytes = level_bytes(check, options, position->schema.record_bytes());
  // options.own_scheme points into `own_schemes`, so the function keeps both.
  result.make = [options, own_schemes, type = position->schema.type](
                    Store& made, int threads,
                    const std::function<bool(std::uint64_t, std::uint64_t)>& proceed) {
    SubdivideOptions how = options;
    how.threads = threads;
    how.proceed = [&proceed](const SubdivideProgress& now) {
      return proceed(now.vertices_done, now.vertices_total);
    };
    add_base_positions(made, type == ComponentType::kFloat64);
    subdivide(made, how);
  };
  return result;
}

}  // namespace

PlanRecomputation recompute_subdivision(std::vector<OneRingScheme> own_schemes) {
  return [own = std::make_shared<const std::vector<OneRingScheme>>(std::move(own_schemes))](
             const StoreCheck& check) { return plan(check, own); };
}

PLAIT_END_NAMESPACE
