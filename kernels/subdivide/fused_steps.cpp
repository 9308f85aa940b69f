#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/zeroed_array.h"
#include "butterfly/base_middles.h"
#include "fused/surface_refiner.h"
#include "mesh/mesh_piece.h"
#include "mesh/mesh_region.h"
#include "plait/extend/base_relative_level.h"
#include "plait/extend/fused.h"
#include "plait/extend/store_access.h"
#include "schemes/one_ring_steps.h"
#include "subdivide/steps.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

BaseRelativeLevel finest(const Store& store, const SubdivideOptions& options) {
  return relative_to_base(options.levels, store.base_level());
}

FusedPass fused_pass(const Store& store, const SubdivideOptions& options, int ring_count,
                     AttributeId position, AttributeId normal) {
  FusedPass pass;
  pass.name = "subdivision";
  pass.outputs = {position};
  if (normal != kNoId) pass.outputs.push_back(normal);
  pass.finest_level = options.levels;
  pass.lattice = surface_lattice(finest(store, options).refinements, ring_count);
  return pass;
}

template <class Real>
FusedOptions fused_options(const SubdivisionRun<Real>& run) {
  FusedOptions how;
  how.threads = run.options.threads;
  how.progress = [&run](const Progress& now) {
    run.report("subdivision", run.vertices_total, now.done, now.total);
    return true;
  };
  return how;
}

/// Whether the pass takes the base mesh in pieces. A scheme of two rings has level 1 in memory.
template <class Rule>
bool takes_pieces(const Store& store) {
  return Rule::kRingCount == 1 && StoreAccess::takes_pieces(store);
}

/// What the pass has in memory for the vertices of a piece of the base mesh.
template <class Rule>
class PieceWork {
 public:
  using Real = typename Rule::Real;

  PieceWork(Store& store, const Rule& rule, const SubdivideOptions& options, AttributeId position,
            AttributeId normal)
      : store_(store),
        position_(position),
        normal_(normal),
        limit_(options.limit),
        refinement_{{rule, {}, {}, finest(store, options).refinements}, {}} {}

  std::uint64_t bytes_of_vertex() const {
    return sizeof(Vector3<Real>) * (limit_ ? 2 : 1) +
           (normal_ != kNoId ? sizeof(Vector3<float>) : 0) + sizeof(VertexId) +
           sizeof(Vector3<Real>);
  }

  void begin(const MeshPiece& piece) {
    positions_.assign(piece.vertices.size(), {});
    limits_.assign(limit_ ? piece.vertices.size() : 0, {});
    normals_.assign(normal_ != kNoId ? piece.vertices.size() : 0, {});
    refinement_.source.mesh = piece.topology();
    refinement_.source.imported = piece.positions;
    refinement_.results = {positions_, limits_, normals_};
    refinement_.source.hubs = nullptr;
    hubs_ = std::make_unique<BaseRings<Rule>>(refinement_.source);
    hubs_->evaluate_hubs(BaseRings<Rule>::find_hubs(refinement_.source.mesh, piece.walkable));
    refinement_.source.hubs = hubs_.get();
  }

  std::unique_ptr<PatchRefiner> refiner() const { return make_refiner(refinement_); }

  void end(const MeshPiece& piece) {
    put(piece, position_, limit_ ? limits_ : positions_);
    if (normal_ != kNoId) put(piece, normal_, normals_);
  }

 private:
  template <class Record>
  void put(const MeshPiece& piece, AttributeId attribute, const std::vector<Record>& results) {
    std::vector<VertexId> vertices;
    std::vector<Record> records;
    for (const VertexId vertex : piece.own) {
      vertices.push_back(piece.vertices[vertex]);
      records.push_back(results[vertex]);
    }
    StoreAccess::put_base_records(store_, attribute, vertices, std::as_bytes(std::span(records)));
  }

  Store& store_;
  AttributeId position_, normal_;
  bool limit_;
  SurfaceRefinement<Rule> refinement_;
  std::unique_ptr<BaseRings<Rule>> hubs_;
  std::vector<Vector3<Real>> positions_, limits_;  ///< [vertex of the piece]
  std::vector<Vector3<float>> normals_;
};

/// The records of base vertices that the patches read are those of the mesh, so the results may
/// take their place at once.
template <class Rule>
void run_in_pieces(SubdivisionRun<typename Rule::Real>& run, const Rule& rule, AttributeId normal) {
  PieceWork<Rule> work(run.store, rule, run.options, run.position, normal);
  FusedPass pass = fused_pass(run.store, run.options, Rule::kRingCount, run.position, normal);
  pass.bytes_of_piece_vertex = work.bytes_of_vertex();
  pass.begin_piece = [&](const MeshPiece& piece) { work.begin(piece); };
  pass.end_piece = [&](const MeshPiece& piece) { work.end(piece); };
  pass.make_refiner = [&] { return work.refiner(); };
  StoreAccess::begin_base_change(run.store, run.position, Access::kUpdate);
  if (normal != kNoId) StoreAccess::begin_base_change(run.store, normal, Access::kUpdate);
  fused(run.store, pass, fused_options(run));
}

}  // namespace

template <class Rule>
void run_fused(SubdivisionRun<typename Rule::Real>& run, const Rule& rule, AttributeId normal) {
  using Real = typename Rule::Real;
  if (takes_pieces<Rule>(run.store)) return run_in_pieces(run, rule, normal);
  Store& store = run.store;
  const SubdivideOptions& options = run.options;
  const int levels = finest(store, options).refinements;
  const std::span<Vector3<Real>> base =
      StoreAccess::base_records<Vector3<Real>>(store, run.position);
  // The patches read the base mesh until the last one is done, so the results are separate arrays.
  ZeroedArray<Vector3<Real>> positions(base.size()), limits(options.limit ? base.size() : 0);

  const Topology mesh = store.base().topology();
  const std::vector<Vector3<Real>> middles =
      first_middles(rule, mesh, std::span<const Vector3<Real>>(base));
  SurfaceRefinement<Rule> refinement{{rule, mesh, base, levels, middles}, {positions, limits, {}}};
  if (normal != kNoId)
    refinement.results.normals = StoreAccess::base_records<Vector3<float>>(store, normal);

  BaseRings<Rule> hubs(refinement.source);
  hubs.evaluate_hubs(BaseRings<Rule>::find_hubs(store.base()));
  refinement.source.hubs = &hubs;

  FusedPass pass = fused_pass(store, options, Rule::kRingCount, run.position, normal);
  pass.make_refiner = [&] { return make_refiner(refinement); };
  fused(store, pass, fused_options(run));
  const std::span<const Vector3<Real>> results = options.limit ? limits : positions;
  const VerticesAtHand vertices = walkable_vertices(store.base());
  for (std::size_t at = 0; at < vertices.size(); ++at) base[vertices[at]] = results[vertices[at]];
}

template <class Rule>
std::uint64_t fused_resident_bytes(const Store& store, const SubdivideOptions& options) {
  using Real = typename Rule::Real;
  const int levels = finest(store, options).refinements;
  const std::array<std::size_t, 2> records = {sizeof(Vector3<Real>), sizeof(Vector3<float>)};
  const std::uint64_t scratch = static_cast<std::uint64_t>(options.threads) *
                                surface_scratch_bytes<Real>(levels, Rule::kRingCount);
  const auto of_executor = [&] {
    return fused_needs(store, std::span(records).first(options.normals ? 2 : 1), options.levels,
                       options.threads)
        .resident;
  };
  if (takes_pieces<Rule>(store)) return store.base().piece_bytes() + of_executor() + scratch;
  const EdgeRange here = StoreAccess::edges(store);
  const std::uint64_t vertices = walkable_vertices(store.base()).size(),
                      edges = store.base().edge_count();
  // A scheme of two rings has level 1 in memory. The rings and the values in double from
  // which level 1 is made are freed before the pass allocates its memory: new base records, the
  // waiting halves and their table, hubs, and scratch memory for each thread.
  constexpr bool keeps_level_1 = Rule::kRingCount == 2;
  const std::uint64_t level_1 = keeps_level_1 ? edges * sizeof(Vector3<Real>) : 0,
                      for_level_1 = keeps_level_1 ? edges * (2 * sizeof(Vector3<Real>) + 48) : 0;
  const std::uint64_t pass_bytes = vertices * sizeof(Vector3<Real>) * (options.limit ? 2 : 1) +
                                   (here.after - here.first) * sizeof(void*) + of_executor() +
                                   BaseRings<Rule>::hub_bytes(store.base(), levels) + scratch +
                                   sizeof(std::uint32_t) * vertices;
  return level_1 + std::max(for_level_1, pass_bytes);
}

template void run_fused(SubdivisionRun<float>&, const OneRing<float>&, AttributeId);
template void run_fused(SubdivisionRun<double>&, const OneRing<double>&, AttributeId);
template void run_fused(SubdivisionRun<float>&, const Butterfly<float>&, AttributeId);
template void run_fused(SubdivisionRun<double>&, const Butterfly<double>&, AttributeId);
template std::uint64_t fused_resident_bytes<OneRing<float>>(const Store&, const SubdivideOptions&);
template std::uint64_t fused_resident_bytes<OneRing<double>>(const Store&, const SubdivideOptions&);
template std::uint64_t fused_resident_bytes<Butterfly<float>>(const Store&,
                                                              const SubdivideOptions&);
template std::uint64_t fused_resident_bytes<Butterfly<double>>(const Store&,
                                                               const SubdivideOptions&);

PLAIT_END_NAMESPACE
