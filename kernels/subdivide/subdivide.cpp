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
#include "plait/progress.h"
#include "schemes/table.h"
#include "subdivide/steps.h"
#include "subdivide/subdivision_start.h"

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

/// Replacements for attributes of the store, or new ones.
struct Replacements {
  AttributeId normal = kNoId, limit = kNoId;
};

/// The positions, normals and limit positions of one run, and what of them is unfinished.
template <class Rule>
class Work {
 public:
  using Real = typename Rule::Real;

  Work(Store& store, const SubdivideOptions& options, const SubdivisionStart& start,
       const Rule& rule)
      : start_(start), rule_(rule), run_(store, options, store.attribute("position")) {
    run_.vertices_total = planned_vertices(store, options, start.level() + 1);
  }

  void run() {
    if (is_fused()) return make_all();
    read_rings(run_, start_.level());
    for (int level = start_.level() + 1; level <= options().levels; ++level) make_level(level);
    if (options().normals || options().limit) make_surface_of_finest();
  }

 private:
  Store& store() const { return run_.store; }
  const SubdivideOptions& options() const { return run_.options; }
  bool is_fused() const { return options().executor == ExecutorKind::kFused; }
  bool sweeps() const { return options().executor != ExecutorKind::kTransparent; }
  int first_level() const { return store().base_level() + 1; }

  /// Marks the base records first, so that nothing of the work can be committed before all is done.
  void mark_base(AttributeId id, Access access) {
    unfinished_.add_base(StoreAccess::base_records_of(store(), id), access);
  }
  void mark(AttributeId id, int level, Access access) {
    unfinished_.add(StoreAccess::level_file(store(), id, level), access);
  }
  void record(bool limit) {
    Provenance provenance = start_.provenance();
    provenance.limit = limit;
    StoreAccess::set_provenance(store(), provenance);
  }
  void add_levels(AttributeId id) {
    for (int level = first_level(); level <= options().levels; ++level) {
      store().add_level(id);
      mark(id, level, Access::kOverwrite);
    }
  }
  AttributeId add_replacement(const AttributeSchema& schema) {
    const AttributeId id = StoreAccess::add_replacement(store(), schema);
    mark_base(id, Access::kOverwrite);
    if (is_fused()) StoreAccess::plan_levels(store(), id, options().levels);
    add_levels(id);
    return id;
  }

  /// All levels and the surface in one pass.
  void make_all() {
    const AttributeId position = run_.position;
    mark_base(position, Access::kUpdate);
    record(options().limit);
    StoreAccess::plan_levels(store(), position, options().levels);
    add_levels(position);
    const AttributeId normal =
        options().normals ? add_replacement(schema_of<Vector3<float>>("normal")) : kNoId;
    run_fused(run_, rule_, normal);
    if (normal != kNoId) StoreAccess::name_replacement(store(), normal);
    unfinished_.finish();
  }

  void make_level(int level) {
    const AttributeId position = run_.position;
    mark_base(position, Access::kUpdate);
    record(false);
    store().add_level(position);
    // Coarser levels only if their vertices move.
    const int first = traits_of(options().scheme).moves_even ? first_level() : level;
    for (int written = level; written >= first; --written) mark(position, written, Access::kUpdate);
    sweeps() ? make_odd(run_, rule_, level) : make_odd_transparent(run_, rule_, level);
    if constexpr (Rule::kRingCount == 1)
      if (rule_.moves_even())
        sweeps() ? move_even(run_, rule_, level) : move_even_transparent(run_, rule_, level);
    unfinished_.finish();
    const StorePass pause(std::as_const(store()), StorePass::Kind::kPause);
    if (options().level_done) options().level_done(level);
  }

  /// What the store has under these names stays until all of the surface is complete.
  void make_surface_of_finest() {
    const int level = options().levels;
    const AttributeSchema of_position = store().attributes()[run_.position].schema;
    const AttributeId normal =
        options().normals ? add_replacement(schema_of<Vector3<float>>("normal")) : kNoId;
    const AttributeId limit = options().limit ? add_replacement(of_position) : kNoId;
    sweeps() ? make_surface(run_, rule_, level, normal, limit)
             : make_surface_transparent(run_, rule_, level, normal, limit);
    // From the last one on, because naming one may move those after it.
    if (limit != kNoId) StoreAccess::name_replacement(store(), limit);
    if (normal != kNoId) StoreAccess::name_replacement(store(), normal);
    if (limit != kNoId) record(true);
    unfinished_.finish();
  }

  const SubdivisionStart& start_;
  const Rule& rule_;
  SubdivisionRun<Real> run_;
  UnfinishedLevels unfinished_;  ///< until all passes over the levels have ended
};

}  // namespace

SubdivideOptions with_threads(SubdivideOptions options) {
  options.threads = thread_count(options.threads, "subdivide");
  return options;
}

void subdivide(Store& store, const SubdivideOptions& options) try {
  const DefaultArithmetic arithmetic;
  const AttributeSchema schema = store.attributes()[store.attribute("position")].schema;
  const bool is_double = schema.type == ComponentType::kFloat64 && schema.components == 3;
  if (!is_double)
    StoreAccess::check_type(store, store.attribute("position"), ComponentType::kFloat32, 3);
  const SubdivisionStart start(store, options);
  SubdivideOptions chosen = start.options();
  // The fused executor makes levels. Normals of base vertices alone are a sweep's work.
  if (chosen.levels == store.base_level() && chosen.executor == ExecutorKind::kFused)
    chosen.executor = ExecutorKind::kSweep;
  const auto run = [&](const auto& rule) { Work(store, chosen, start, rule).run(); };
  is_double ? with_rule<double>(options.scheme, run) : with_rule<float>(options.scheme, run);
} catch (const std::bad_alloc&) {
  throw out_of_memory("subdivide " + store.path().native());
}

std::uint64_t subdivide_resident_bytes(const Store& store, const SubdivideOptions& wanted) {
  const SubdivideOptions options = with_threads(wanted);
  const std::uint64_t record_bytes =
      store.attributes()[store.attribute("position")].schema.record_bytes();
  if (executor_for(store, options) == ExecutorKind::kFused && options.levels > store.base_level()) {
    const auto bytes = [&]<class Rule>(const Rule&) {
      return fused_resident_bytes<Rule>(store, options);
    };
    return record_bytes == sizeof(Vector3<double>) ? with_rule<double>(options.scheme, bytes)
                                                   : with_rule<float>(options.scheme, bytes);
  }
  // A scheme of two rings has the rings of two levels in memory, and its extraordinary
  // values.
  const bool two_rings = traits_of(options.scheme).ring_count == 2;
  const std::uint64_t side =
      (std::uint64_t{1} << relative_to_base(options.levels, store.base_level()).refinements) + 3;
  return (2 * record_bytes * (two_rings ? 2 : 1) + (two_rings ? 48 : 0)) *
             store.base().edge_count() +
         static_cast<std::uint64_t>(options.threads) * side * side * record_bytes;
}

PLAIT_END_NAMESPACE
