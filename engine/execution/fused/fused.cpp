#include "plait/extend/fused.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/default_arithmetic.h"
#include "base/run_workers.h"
#include "execution/fused/fused_faces.h"
#include "execution/fused/fused_schedule.h"
#include "execution/fused/slot_delivery.h"
#include "mesh/mesh_piece.h"
#include "plait/error.h"
#include "plait/extend/store_access.h"
#include "plait/progress.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The objects that the threads of a pass share while they work on a mesh or a piece of it.
class FusedRun {
 public:
  FusedRun(Store& store, const FusedPass& pass, const FusedMesh& mesh, OpenBlocks& blocks,
           int threads)
      : pass_(pass),
        delivery_(store, pass, mesh, blocks),
        faces_(mesh.mesh, mesh.edges, FusedSchedule::run_faces(level_count(store, pass)), threads),
        schedule_(faces_, threads) {}

  std::uint64_t face_count() const { return faces_.all().size(); }

  FusedSchedule& schedule() { return schedule_; }

  /// Refines runs of faces until none is left, as the thread with this number.
  void work(int thread, const std::function<void()>& after_run) {
    const DefaultArithmetic arithmetic;
    const std::unique_ptr<PatchRefiner> refiner = pass_.make_refiner();
    SlotDelivery::Scratch scratch(delivery_);
    while (const std::optional<std::uint64_t> run = schedule_.next(thread)) {
      const std::span<const FaceId> faces = faces_.run(*run);
      refiner->begin(faces);
      for (std::size_t first = 0; first < faces.size(); first += kPatchLanes) {
        const std::size_t count = std::min(kPatchLanes, faces.size() - first);
        refiner->refine(first, count);
        delivery_.deliver(*refiner, faces.subspan(first, count), scratch);
      }
      schedule_.done(thread);
      after_run();
    }
  }

 private:
  const FusedPass& pass_;
  SlotDelivery delivery_;
  const FusedFaces faces_;
  FusedSchedule schedule_;
};

void check_pass(const Store& store, const FusedPass& pass) {
  if (pass.outputs.empty())
    throw Error(ErrorCode::kInvalidArgument, fmt::format("fused '{}': no outputs", pass.name));
  const int levels = level_count(store, pass);
  if (levels > kMostFusedLevels)
    throw Error(ErrorCode::kNotSupported,
                fmt::format("fused '{}': {} levels over the store's base mesh, expected at most "
                            "{}: take smaller slots (a finer base mesh) or another executor",
                            pass.name, levels, kMostFusedLevels));
  std::vector<const LevelFile*> written;
  for (const AttributeId id : pass.outputs) {
    if (id >= store.attributes().size() || levels < 1 ||
        pass.finest_level > store.attributes()[id].finest_level)
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("fused '{}': attribute {} has no levels {} to {}", pass.name, id,
                              store.base_level() + 1, pass.finest_level));
    const AttributeSchema& schema = store.attributes()[id].schema;
    if (const std::size_t bytes = component_bytes(schema.type); bytes != 4 && bytes != 8)
      throw Error(ErrorCode::kNotSupported,
                  fmt::format("fused '{}': '{}' has components of {} bytes, expected 4 or 8",
                              pass.name, schema.name, bytes));
    if (std::ranges::count(pass.outputs, id) > 1)
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("fused '{}': '{}' is more than one output", pass.name, schema.name));
    for (int level = store.base_level() + 1; level <= pass.finest_level; ++level) {
      written.push_back(&StoreAccess::level_file(store, id, level));
      check_not_fixed(*written.back());
    }
  }
  check_not_encoded_from_each_other(written);
  if (const std::int64_t size = std::int64_t{1} << levels;
      pass.lattice.size != size || pass.lattice.halo < 0)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("fused '{}': a lattice of size {} with a halo of {}, expected size {} "
                            "and no negative halo",
                            pass.name, pass.lattice.size, pass.lattice.halo, size));
}

}  // namespace

void fused(Store& store, const FusedPass& pass, const FusedOptions& options) try {
  const int threads = thread_count(options.threads, fmt::format("fused '{}'", pass.name));
  StoreAccess::refuse_depths(store, fmt::format("fused '{}' over", pass.name), pass.finest_level);
  check_pass(store, pass);
  const std::uint64_t needed_bytes =
      fused_frame_bytes(store, fused_record_bytes(store, pass), pass.finest_level, threads);
  if (needed_bytes > StoreAccess::pager(store).budget_bytes())
    throw Error(
        ErrorCode::kBudget,
        fmt::format("fused '{}': {} threads fill {} bytes of blocks at once, and the budget has "
                    "{} for them; a block has {} bytes: raise the budget, take smaller blocks or "
                    "fewer threads",
                    pass.name, threads, needed_bytes, StoreAccess::pager(store).budget_bytes(),
                    store.options().block_bytes));

  const StorePass under_way(store, fmt::format("fused '{}' of", pass.name));
  UnfinishedLevels written;
  for (const AttributeId id : pass.outputs)
    for (int level = store.base_level() + 1; level <= pass.finest_level; ++level)
      written.add(StoreAccess::level_file(store, id, level), Access::kOverwrite);
  OpenBlocks blocks(store, pass.outputs, level_count(store, pass));
  // `done` and `share` are parts of all faces: those before these ones, and these ones.
  const auto refine = [&](const FusedMesh& mesh, double done, double share) {
    FusedRun run(store, pass, mesh, blocks, threads);
    const std::uint64_t total = share < 1 ? store.base().face_count() : run.face_count();
    const auto report = [&] {
      std::uint64_t faces = run.schedule().faces_done();
      if (share < 1)  // ghosts at the cuts are no faces of their own
        faces = static_cast<std::uint64_t>(
            (done + share * static_cast<double>(faces) / static_cast<double>(run.face_count())) *
            static_cast<double>(total));
      if (options.progress && !options.progress({pass.name, faces, total}))
        throw Error(ErrorCode::kCancelled, fmt::format("fused '{}': cancelled", pass.name));
    };
    run_workers(store.options().parallel_for, threads, fmt::format("fused '{}'", pass.name),
                {[&](int worker, const auto& ended) { run.work(worker, ended); }, report,
                 [&] { run.schedule().stop(); }});
  };
  if (StoreAccess::takes_pieces(store) && pass.begin_piece) {
    const std::size_t half_bytes =
        HalfLayout::half_bytes(fused_record_bytes(store, pass), level_count(store, pass));
    const auto edges = static_cast<EdgeId>(store.base().edge_count());
    // From the last to the first, as faces are taken, so that blocks at cuts wait for one piece.
    for (EdgeId after = edges; after > 0;) {
      const MeshPiece piece =
          take_last_piece(store.base(), after, pass.bytes_of_piece_vertex, half_bytes);
      pass.begin_piece(piece);
      const double all = edges;
      refine({piece.topology(), {piece.edges_before, piece.edges_after()}, piece.first},
             (edges - after) / all, (after - piece.first) / all);
      pass.end_piece(piece);
      after = piece.first;
    }
  } else {
    const EdgeRange here = StoreAccess::edges(store);
    refine({store.base().topology(), here, here.first}, 0, 1);
  }
  written.finish();
} catch (const std::bad_alloc&) {
  throw out_of_memory("fused " + pass.name);
}

PLAIT_END_NAMESPACE
