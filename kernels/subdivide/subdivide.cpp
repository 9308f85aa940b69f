#include "plait/kernels/subdivide.h"

#include <fmt/format.h>

#include <string>

#include "plait/base_relative_level.h"
#include "plait/edge_index.h"
#include "plait/error.h"
#include "schemes/table.h"
#include "subdivide/steps.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

void check_subdivision(const Store& store, const SubdivideOptions& options) {
  if (options.levels < store.base_level() || options.levels > kMaxLevel)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("subdivide to level {}: expected {} to {}", options.levels,
                            store.base_level(), kMaxLevel));
  if (options.threads < 1 || options.threads > 1024)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("subdivide: {} threads, expected 1 to 1024", options.threads));
  if (const SchemeTraits scheme = traits_of(options); options.limit && !scheme.has_limits)
    throw Error(ErrorCode::kNotSupported,
                fmt::format("subdivide: scheme {} has no limit positions", scheme.name));
  if (store.has_attribute("limit"))
    throw Error(ErrorCode::kInvalidArgument,
                "subdivide: the store has an attribute 'limit' already");
  if (store.has_attribute("normal") && !options.normals)
    throw Error(
        ErrorCode::kInvalidArgument,
        "subdivide: the store has normals, which do not fit a finer level: ask for normals, so "
        "that new ones are computed");
}

/// The number of vertices that the whole run computes. An even vertex counts each time that it
/// moves.
std::uint64_t planned_vertices(const Store& store, const SubdivideOptions& options,
                               int first_level) {
  const std::uint64_t interior = store.base().edge_count() - store.base().border_edge_count();
  const auto born = [&](int level) {
    const int refinements = relative_to_base(level, store.base_level()).refinements;
    return interior * slot_records(refinements) +
           store.base().border_edge_count() * slot_records(refinements, true);
  };
  const int first = store.base_level() + 1;
  std::uint64_t total = 0;
  for (int level = first_level; level <= options.levels; ++level) {
    total += born(level);
    if (traits_of(options).moves_even)
      for (int older = first; older < level; ++older) total += born(older);
  }
  if (options.normals || options.limit)
    for (int level = first; level <= options.levels; ++level) total += born(level);
  return total;
}

/// Records in the provenance how this run makes the levels.
template <class Real>
void record(Store& store, const SubdivideOptions& options, bool limit, bool only_this_run) {
  Provenance provenance = store.provenance();
  provenance.scheme = only_this_run ? traits_of(options).name : "";
  provenance.limit = limit;
  provenance.precision = RecordTraits<Real>::kType;
  provenance.program = program_version();
  store.set_provenance(provenance);
}

template <class Rule>
void run_subdivision(Store& store, const SubdivideOptions& options, AttributeId position,
                     const Rule& rule) {
  using Real = typename Rule::Real;
  const bool sweeping = options.executor != ExecutorKind::kTransparent;
  const int base_level = store.base_level(), levels = options.levels;
  const int done = store.attributes()[position].finest_level;
  const bool fused = options.executor == ExecutorKind::kFused && levels > base_level;
  UnfinishedLevels unfinished;  // until all passes over the levels have ended
  const auto add_levels = [&](AttributeId id) {
    for (int level = base_level + 1; level <= levels; ++level) {
      store.add_level(id);
      unfinished.add(store.level_file(id, level), Access::kOverwrite);
    }
  };
  const auto add = [&](bool wanted, const AttributeSchema& schema) {
    if (!wanted) return kNoId;
    const AttributeId id = store.add_attribute(schema);
    if (fused) store.plan_levels(id, levels);
    add_levels(id);
    return id;
  };
  // If the existing levels are limit positions or were made by another scheme, this scheme alone
  // would not have made them. So the provenance names no scheme.
  const Provenance before = store.provenance();
  const bool only_this_run =
      done == base_level || (before.scheme == traits_of(options).name && !before.limit);
  if (levels > done) record<Real>(store, options, false, only_this_run);
  SubdivisionRun<Real> run(store, options, position);
  run.vertices_total = planned_vertices(store, options, done + 1);
  if (fused) {
    if (done > base_level)
      throw Error(ErrorCode::kNotSupported,
                  fmt::format("subdivide: the fused executor starts at the base mesh, and the "
                              "store has level {}: take sweep",
                              done));
    if (options.limit) record<Real>(store, options, true, only_this_run);
    store.plan_levels(position, levels);
    add_levels(position);
    run_fused(run, rule, add(options.normals, schema_of<Vector3<float>>("normal")));
    unfinished.finish();
    return;
  }
  read_rings(run, done);

  for (int level = done + 1; level <= levels; ++level) {
    store.add_level(position);
    for (int written = base_level + 1; written <= level; ++written)
      unfinished.add(store.level_file(position, written), Access::kUpdate);
    sweeping ? make_odd(run, rule, level) : make_odd_transparent(run, rule, level);
    if constexpr (Rule::kReach == 1)
      if (rule.moves_even())
        sweeping ? move_even(run, rule, level) : move_even_transparent(run, rule, level);
    unfinished.finish();
    if (options.level_done) options.level_done(level);
  }
  if (!options.normals && !options.limit) return;

  // The committed normals must stay readable until all new normals are complete, so the new ones
  // are another attribute at first.
  const bool replaces_normals = store.has_attribute("normal");
  const AttributeId normal =
      add(options.normals, schema_of<Vector3<float>>(replaces_normals ? "normal_anew" : "normal"));
  const AttributeId limit = add(options.limit, schema_of<Vector3<Real>>("limit"));
  sweeping ? make_surface(run, rule, levels, normal, limit)
           : make_surface_transparent(run, rule, levels, normal, limit);
  unfinished.finish();
  if (limit != kNoId) {
    store.replace_attribute(position, limit);
    record<Real>(store, options, true, only_this_run);
  }
  if (replaces_normals)
    store.replace_attribute(store.attribute("normal"), store.attribute("normal_anew"));
}

template <class Real>
void fill_base(Store& store) {
  const AttributeId position = store.add_attribute(schema_of<Vector3<Real>>("position"));
  const std::span<Vector3<Real>> records = store.base_records<Vector3<Real>>(position);
  for (std::size_t vertex = 0; vertex < records.size(); ++vertex) {
    const Vector3<double>& from = store.base().positions()[vertex];
    records[vertex] = {static_cast<Real>(from.x), static_cast<Real>(from.y),
                       static_cast<Real>(from.z)};
  }
}

}  // namespace

void add_base_positions(Store& store, bool double_precision) {
  double_precision ? fill_base<double>(store) : fill_base<float>(store);
}

void subdivide(Store& store, const SubdivideOptions& options) {
  check_subdivision(store, options);
  const AttributeId position = store.attribute("position");
  const AttributeSchema& schema = store.attributes()[position].schema;
  const auto run = [&](const auto& rule) { run_subdivision(store, options, position, rule); };
  if (schema.type == ComponentType::kFloat64 && schema.components == 3)
    return with_rule<double>(options, run);
  store.check_type(position, ComponentType::kFloat32, 3);
  with_rule<float>(options, run);
}

std::uint64_t subdivide_resident_bytes(const Store& store, const SubdivideOptions& options) {
  const std::uint64_t record_bytes =
      store.attributes()[store.attribute("position")].schema.record_bytes();
  if (options.executor == ExecutorKind::kFused && options.levels > store.base_level()) {
    const auto bytes = [&]<class Rule>(const Rule&) {
      return fused_resident_bytes<Rule>(store, options);
    };
    return record_bytes == sizeof(Vector3<double>) ? with_rule<double>(options, bytes)
                                                   : with_rule<float>(options, bytes);
  }
  // A scheme with a reach of two has the rings of two levels in memory, and its extraordinary
  // values.
  const bool two_rings = traits_of(options).reach == 2;
  const std::uint64_t side =
      (std::uint64_t{1} << relative_to_base(options.levels, store.base_level()).refinements) + 3;
  return (2 * record_bytes * (two_rings ? 2 : 1) + (two_rings ? 48 : 0)) *
             store.base().edge_count() +
         static_cast<std::uint64_t>(options.threads) * side * side * record_bytes;
}

PLAIT_END_NAMESPACE
