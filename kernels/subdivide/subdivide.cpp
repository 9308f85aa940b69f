#include "plait/subdivide.h"

#include <fmt/format.h>

#include <new>
#include <string_view>
#include <utility>

#include "base/default_arithmetic.h"
#include "base/text.h"
#include "normals/normal_rules.h"
#include "plait/detail/base_vertices.h"
#include "plait/error.h"
#include "plait/extend/pager.h"
#include "plait/extend/store_access.h"
#include "plait/progress.h"
#include "schemes/table.h"
#include "subdivide/steps.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr NameTable<ExecutorKind, 4> kExecutors("executor",
                                                {{ExecutorKind::kAuto, "auto"},
                                                 {ExecutorKind::kFused, "fused"},
                                                 {ExecutorKind::kSweep, "sweep"},
                                                 {ExecutorKind::kTransparent, "transparent"}});

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

/// The positions, normals and limit positions of one run, and what of them is unfinished.
template <class Rule>
class Work {
 public:
  using Real = typename Rule::Real;
  using Record = Vector3<Real>;

  Work(Store& store, const SubdivideOptions& options, int finest_level,
       const Provenance& provenance, const Rule& rule)
      : finest_level_(finest_level),
        provenance_(provenance),
        rule_(rule),
        run_(store, options, store.attribute("position")) {
    run_.vertices_total = planned_vertices(store, options, finest_level + 1);
  }

  void run() {
    if (is_fused()) return make_all();
    read_rings(run_, finest_level_);
    for (int level = finest_level_ + 1; level <= options().levels; ++level) make_level(level);
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
    Provenance provenance = provenance_;
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
      if (rule_.moves_even()) {
        if (level > first_level())
          sweeps() ? move_even(run_, rule_, level) : move_even_transparent(run_, rule_, level);
        move_base_vertices(store().base().topology(), run_.rings, rule_,
                           StoreAccess::base_records<Record>(store(), position));
      }
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
    if (level >= first_level())
      sweeps() ? make_surface(run_, rule_, level, normal, limit)
               : make_surface_transparent(run_, rule_, level, normal, limit);
    const Topology mesh = store().base().topology();
    const auto base = std::as_const(store()).template base_records<Record>(run_.position);
    if (normal != kNoId)
      normals::base(mesh, run_.rings, base,
                    StoreAccess::base_records<Vector3<float>>(store(), normal));
    if constexpr (Rule::kRingCount == 1)
      if (limit != kNoId)
        limit_base_vertices(mesh, run_.rings, rule_, base,
                            StoreAccess::base_records<Record>(store(), limit));
    // From the last one on, because naming one may move those after it.
    if (limit != kNoId) StoreAccess::name_replacement(store(), limit);
    if (normal != kNoId) StoreAccess::name_replacement(store(), normal);
    if (limit != kNoId) record(true);
    unfinished_.finish();
  }

  const int finest_level_;  ///< of the positions, before the work
  const Provenance& provenance_;
  const Rule& rule_;
  SubdivisionRun<Real> run_;
  UnfinishedLevels unfinished_;  ///< until all passes over the levels have ended
};

}  // namespace

std::string_view to_string(ExecutorKind executor) noexcept { return kExecutors.name_of(executor); }

ExecutorKind executor_from_name(std::string_view name) { return kExecutors.find(name); }

void PlannedSubdivision::run() try {
  const DefaultArithmetic arithmetic;
  const AttributeInfo& position = store_->attributes()[position_];
  if (position.finest_level != first_level_)
    throw Error(ErrorCode::kBadState,
                fmt::format("subdivide: planned for positions of level {}, found level {}: plan "
                            "again after a change of the store",
                            first_level_, position.finest_level));
  check_budget();
  const LentMemory lent(StoreAccess::pager(*store_), lent_bytes_);
  const auto work = [&](const auto& rule) {
    Work(*store_, options_, first_level_, provenance_, rule).run();
  };
  position.schema.type == ComponentType::kFloat64 ? with_rule<double>(options_.scheme, work)
                                                  : with_rule<float>(options_.scheme, work);
} catch (const std::bad_alloc&) {
  throw out_of_memory("subdivide " + store_->path().native());
}

void subdivide(Store& store, const SubdivideOptions& options) try {
  plan_subdivision(store, options).run();
} catch (const std::bad_alloc&) {
  throw out_of_memory("subdivide " + store.path().native());
}

PLAIT_END_NAMESPACE
