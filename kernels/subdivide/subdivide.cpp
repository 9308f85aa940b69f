#include "plait/subdivide.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "base/default_arithmetic.h"
#include "plait/error.h"
#include "plait/extend/base_relative_level.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/store_access.h"
#include "plait/extend/thread_count.h"
#include "schemes/table.h"
#include "subdivide/beginning.h"
#include "subdivide/steps.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The number of vertices that the whole run computes. An even vertex counts each time that it
/// moves.
std::uint64_t planned_vertices(const Store& store, const SubdivideOptions& options,
                               int first_level) {
  const int first = store.base_level() + 1;
  std::uint64_t total = 0;
  for (int level = first_level; level <= options.levels; ++level)
    total += vertices_born(store, traits_of(options.scheme).moves_even ? first : level, level);
  if (options.normals || options.limit) total += vertices_born(store, first, options.levels);
  return total;
}

/// Records in the provenance how this run makes the levels.
template <class Real>
void record(Store& store, const SubdivideOptions& options, bool limit, bool only_this_run) {
  Provenance provenance = store.provenance();
  provenance.scheme = only_this_run ? traits_of(options.scheme).name : "";
  provenance.limit = limit;
  provenance.precision = RecordTraits<Real>::kType;
  provenance.program = program_version();
  StoreAccess::set_provenance(store, provenance);
}

template <class Rule>
void run_subdivision(Store& store, const SubdivideOptions& options, Beginning& beginning,
                     const Rule& rule) {
  using Real = typename Rule::Real;
  const bool sweeping = options.executor != ExecutorKind::kTransparent;
  const int base_level = store.base_level(), levels = options.levels, done = beginning.level();
  UnfinishedLevels unfinished;  // until all passes over the levels have ended
  const auto add_levels = [&](AttributeId id) {
    for (int level = base_level + 1; level <= levels; ++level) {
      store.add_level(id);
      unfinished.add(StoreAccess::level_file(store, id, level), Access::kOverwrite);
    }
  };
  const auto add = [&](bool wanted, const AttributeSchema& schema) {
    if (!wanted) return kNoId;
    const AttributeId id = beginning.add(schema);
    if (options.executor == ExecutorKind::kFused) StoreAccess::plan_levels(store, id, levels);
    add_levels(id);
    return id;
  };
  // If the existing levels are limit positions or were made by another scheme, this scheme alone
  // would not have made them. So the provenance names no scheme.
  const Provenance before = store.provenance();
  const bool only_this_run =
      done == base_level || (before.scheme == traits_of(options.scheme).name && !before.limit);
  if (levels > done) record<Real>(store, options, false, only_this_run);
  if (options.executor == ExecutorKind::kFused && levels > base_level) {
    if (options.limit) record<Real>(store, options, true, only_this_run);
    StoreAccess::plan_levels(store, store.attribute("position"), levels);
    add_levels(store.attribute("position"));
    beginning.check_budget();
    if (options.normals && store.has_attribute("normal"))
      store.remove_attribute(store.attribute("normal"));
    const AttributeId normal = add(options.normals, schema_of<Vector3<float>>("normal"));
    SubdivisionRun<Real> run(store, options, store.attribute("position"));
    run.vertices_total = planned_vertices(store, options, done + 1);
    run_fused(run, rule, normal);
    unfinished.finish();
    return;
  }
  const AttributeId position = store.attribute("position");
  SubdivisionRun<Real> run(store, options, position);
  run.vertices_total = planned_vertices(store, options, done + 1);
  read_rings(run, done);

  for (int level = done + 1; level <= levels; ++level) {
    store.add_level(position);
    if (level == done + 1) beginning.check_budget();
    // The new level first: if another one refuses, nobody can read it. Coarser ones only if their
    // vertices move.
    const int first = traits_of(options.scheme).moves_even ? base_level + 1 : level;
    for (int written = level; written >= first; --written)
      unfinished.add(StoreAccess::level_file(store, position, written), Access::kUpdate);
    sweeping ? make_odd(run, rule, level) : make_odd_transparent(run, rule, level);
    if constexpr (Rule::kRingCount == 1)
      if (rule.moves_even())
        sweeping ? move_even(run, rule, level) : move_even_transparent(run, rule, level);
    unfinished.finish();
    const StorePass pause(std::as_const(store), StorePass::Kind::kPause);
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

SubdivideOptions with_threads(SubdivideOptions options) {
  options.threads = thread_count(options.threads, "subdivide");
  return options;
}

void check_precision(ComponentType precision) {
  if (precision != ComponentType::kFloat32 && precision != ComponentType::kFloat64)
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("positions of type {}: expected float32 or float64", to_string(precision)));
}

void check_positions(const BaseMesh& mesh, ComponentType precision) {
  check_precision(precision);
  if (precision != ComponentType::kFloat32) return;
  for (std::size_t vertex = 0; vertex < mesh.positions().size(); ++vertex)
    for (const double number :
         {mesh.positions()[vertex].x, mesh.positions()[vertex].y, mesh.positions()[vertex].z})
      if (!std::isfinite(static_cast<float>(number)))
        throw Error(ErrorCode::kInvalidArgument,
                    fmt::format("positions of type float32: vertex {} has {:g}, expected at most "
                                "{:g}: take float64",
                                vertex, number, std::numeric_limits<float>::max()));
}

void add_base_positions(Store& store, ComponentType precision) {
  const DefaultArithmetic arithmetic;
  check_positions(store.base(), precision);
  precision == ComponentType::kFloat64 ? fill_base<double>(store) : fill_base<float>(store);
}

void subdivide(Store& store, const SubdivideOptions& options) try {
  const DefaultArithmetic arithmetic;
  const AttributeSchema schema = store.attributes()[store.attribute("position")].schema;
  const bool is_double = schema.type == ComponentType::kFloat64 && schema.components == 3;
  if (!is_double)
    StoreAccess::check_type(store, store.attribute("position"), ComponentType::kFloat32, 3);
  const SubdivideOptions given = with_threads(options);
  SubdivideOptions chosen = given;
  Beginning beginning(store, given);
  chosen.executor = executor_for(store, given);
  // The fused executor makes levels. Normals of base vertices alone are a sweep's work.
  if (given.levels == store.base_level() && chosen.executor == ExecutorKind::kFused)
    chosen.executor = ExecutorKind::kSweep;
  try {
    beginning.clear_away();
    const auto run = [&](const auto& rule) { run_subdivision(store, chosen, beginning, rule); };
    is_double ? with_rule<double>(options.scheme, run) : with_rule<float>(options.scheme, run);
  } catch (const Error& error) {
    // What the work refuses later leaves no more than what is refused at the beginning.
    beginning.undo(error.code() == ErrorCode::kBudget || error.code() == ErrorCode::kBadState);
    throw;
  } catch (...) {
    beginning.undo(false);
    throw;
  }
  beginning.finish(options.limit);
} catch (const std::bad_alloc&) {
  throw out_of_memory("subdivide " + store.path().native());
}

std::uint64_t subdivide_resident_bytes(const Store& store, const SubdivideOptions& wanted) {
  const SubdivideOptions options = with_threads(wanted);
  const std::uint64_t record_bytes =
      store.attributes()[store.attribute("position")].schema.record_bytes();
  // The base records as they were at the beginning, and before there were levels.
  const std::uint64_t kept = 2 * record_bytes * store.base().vertex_count();
  if (executor_for(store, options) == ExecutorKind::kFused && options.levels > store.base_level()) {
    const auto bytes = [&]<class Rule>(const Rule&) {
      return fused_resident_bytes<Rule>(store, options);
    };
    return kept + (record_bytes == sizeof(Vector3<double>)
                       ? with_rule<double>(options.scheme, bytes)
                       : with_rule<float>(options.scheme, bytes));
  }
  // A scheme of two rings has the rings of two levels in memory, and its extraordinary
  // values.
  const bool two_rings = traits_of(options.scheme).ring_count == 2;
  const std::uint64_t side =
      (std::uint64_t{1} << relative_to_base(options.levels, store.base_level()).refinements) + 3;
  return kept +
         (2 * record_bytes * (two_rings ? 2 : 1) + (two_rings ? 48 : 0)) *
             store.base().edge_count() +
         static_cast<std::uint64_t>(options.threads) * side * side * record_bytes;
}

PLAIT_END_NAMESPACE
