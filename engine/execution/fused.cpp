#include "plait/fused.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "execution/fused_schedule.h"
#include "execution/open_blocks.h"
#include "execution/slot_halves.h"
#include "plait/error.h"

namespace plait {
namespace {

/// What the threads of a pass share. Everything but slots and halves themselves is under the lock,
/// which is taken three times a group.
class FusedRun {
 public:
  FusedRun(Store& store, const FusedPass& pass, int threads)
      : pass_(pass),
        mesh_(store.base().topology()),
        shape_(store, pass.outputs, pass.levels),
        scatter_(pass.lattice, shape_),
        pool_(shape_.bytes),
        blocks_(store, pass.outputs, pass.levels),
        waiting_(store.base().edge_count(), nullptr),
        schedule_(store.base().face_count(), FusedSchedule::run_faces(pass.levels),
                  FusedSchedule::window(threads)) {}

  FusedSchedule& schedule() { return schedule_; }

  /// Takes runs of faces until there are none. The first error of any thread ends all of them.
  template <class AfterRun>
  void work(AfterRun after_run) noexcept {
    try {
      const std::unique_ptr<PatchRefiner> refiner = pass_.make_refiner();
      std::vector<FaceId> faces;
      std::vector<std::byte> spare(shape_.bytes);
      while (const std::optional<FaceRun> run = schedule_.next()) {
        faces.clear();
        for (FaceId face = run->after; face-- > run->first;) faces.push_back(face);
        refiner->begin(faces);
        for (std::size_t first = 0; first < faces.size(); first += kPatchLanes) {
          const std::size_t count = std::min(kPatchLanes, faces.size() - first);
          refiner->refine(first, count);
          deliver(*refiner, std::span(faces).subspan(first, count), spare.data());
        }
        schedule_.done(*run);
        after_run();
      }
    } catch (...) {
      const std::scoped_lock lock(mutex_);
      keep_error();
      schedule_.stop();
    }
  }

  void throw_error() const {
    if (error_) std::rethrow_exception(error_);
  }

 private:
  struct Complete {
    EdgeId edge;
    std::byte *own, *other;  ///< a border edge has no other half
  };

  /// A side of a patch in a group, as the mesh knows it.
  struct Side {
    EdgeId edge;
    bool own, border;
    std::byte* half;
  };

  void deliver(const PatchRefiner& refiner, std::span<const FaceId> faces, std::byte* spare) {
    std::array<std::array<Side, kPatchLanes>, 3> sides;
    for (std::size_t lane = 0; lane < faces.size(); ++lane) {
      const int turn = first_corner(mesh_, faces[lane]);
      for (int side = 0; side < 3; ++side) {
        const FaceSide of_face(faces[lane], (side + turn) % 3);
        const EdgeId edge =
            mesh_.face_edges[of_face.face()][static_cast<std::size_t>(of_face.side())];
        sides[static_cast<std::size_t>(side)][lane] = {edge, mesh_.edges[edge].own == of_face,
                                                       mesh_.edges[edge].is_border(), nullptr};
      }
    }
    {
      const std::scoped_lock lock(mutex_);
      for (auto& lanes : sides)
        for (std::size_t lane = 0; lane < faces.size(); ++lane) lanes[lane].half = pool_.take();
    }
    scatter(refiner, sides, faces.size(), spare);

    std::array<Complete, 3 * kPatchLanes> complete;
    std::size_t count = 0;
    {
      const std::scoped_lock lock(mutex_);
      for (const auto& lanes : sides)
        for (const Side& side : std::span(lanes).first(faces.size())) {
          std::byte*& waiting = waiting_[side.edge];
          if (!waiting && !side.border) {
            waiting = side.half;
            continue;
          }
          Complete& done =
              complete[count++] = {side.edge, side.half, std::exchange(waiting, nullptr)};
          if (!side.own) std::swap(done.own, done.other);
          open(side.edge);
        }
    }
    merge(std::span(complete.data(), count));
    const std::scoped_lock lock(mutex_);
    for (const Complete& done : std::span(complete.data(), count)) {
      blocks_.close(done.edge);
      pool_.give_back(done.own);
      if (done.other) pool_.give_back(done.other);
    }
  }

  void keep_error() {
    if (!error_) error_ = std::current_exception();
  }

  /// Under the lock, and the error too: the next thread's pin would say no more than that a write
  /// has failed, and must not come first.
  void open(EdgeId edge) {
    try {
      blocks_.open(edge);
    } catch (...) {
      keep_error();
      throw;
    }
  }

  void scatter(const PatchRefiner& refiner,
               const std::array<std::array<Side, kPatchLanes>, 3>& sides, std::size_t count,
               std::byte* spare) const {
    GroupHalves halves;
    for (std::size_t side = 0; side < 3; ++side) {
      GroupHalves::Side& to = halves.sides[side];
      to.own.fill(spare);
      to.other.fill(spare);
      for (std::size_t lane = 0; lane < count; ++lane) {
        const Side& from = sides[side][lane];
        (from.own ? to.own : to.other)[lane] = from.half;
        (from.own ? to.any_own : to.any_other) = true;
      }
    }
    for (std::size_t output = 0; output < shape_.outputs.size(); ++output)
      scatter_(output, refiner.points(output), halves);
  }

  void merge(std::span<const Complete> edges) const {
    const bool streaming = blocks_.stays_in_memory();
    for (std::size_t output = 0; output < shape_.outputs.size(); ++output) {
      const HalfShape::Output& shape = shape_.outputs[output];
      for (const Complete& edge : edges) {
        std::size_t own_at = shape.offset, other_at = shape.offset;
        for (int level = 1; level <= pass_.levels; ++level) {
          const std::uint64_t own_records = slot_records(level, true);
          merge_slot(shape.record_bytes, level, edge.own + own_at,
                     edge.other ? edge.other + other_at : nullptr, streaming,
                     blocks_.slot(output, level, edge.edge));
          own_at += own_records * shape.record_bytes;
          other_at += (slot_records(level) - own_records) * shape.record_bytes;
        }
      }
    }
    if (streaming) finish_streaming();
  }

  const FusedPass& pass_;
  const Topology mesh_;
  const HalfShape shape_;
  const HalfScatter scatter_;
  std::mutex mutex_;
  HalfPool pool_;
  OpenBlocks blocks_;
  std::vector<std::byte*> waiting_;  ///< [edge] the half that came first, until the other comes
  std::exception_ptr error_;
  FusedSchedule schedule_;
};

void check_pass(const Store& store, const FusedPass& pass, const FusedOptions& options) {
  if (options.threads < 1 || options.threads > 1024)
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("fused '{}': {} threads, expected 1 to 1024", pass.name, options.threads));
  if (pass.outputs.empty())
    throw Error(ErrorCode::kInvalidArgument, fmt::format("fused '{}': no outputs", pass.name));
  if (pass.levels > kMostFusedLevels)
    throw Error(ErrorCode::kNotSupported,
                fmt::format("fused '{}': {} levels over the store's base mesh, expected at most "
                            "{}: take smaller slots (a finer base mesh) or another executor",
                            pass.name, pass.levels, kMostFusedLevels));
  for (const AttributeId id : pass.outputs) {
    if (id >= store.attributes().size() || pass.levels < 1 ||
        store.base_level() + pass.levels > store.attributes()[id].finest_level)
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("fused '{}': attribute {} has no levels {} to {}", pass.name, id,
                              store.base_level() + 1, store.base_level() + pass.levels));
    const AttributeSchema& schema = store.attributes()[id].schema;
    if (const std::size_t bytes = component_bytes(schema.type); bytes != 4 && bytes != 8)
      throw Error(ErrorCode::kNotSupported,
                  fmt::format("fused '{}': '{}' has components of {} bytes, expected 4 or 8",
                              pass.name, schema.name, bytes));
    if (std::ranges::count(pass.outputs, id) > 1)
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("fused '{}': '{}' is more than one output", pass.name, schema.name));
    if (!store.level_file(id, store.base_level() + 1).writable)
      throw Error(ErrorCode::kBadState,
                  fmt::format("fused '{}': writes to {}, which was opened for reading", pass.name,
                              store.path().native()));
  }
  if (const std::int64_t size = std::int64_t{1} << pass.levels;
      pass.lattice.size != size || pass.lattice.halo < 0)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("fused '{}': a lattice of size {} with a halo of {}, expected size {} "
                            "and no negative halo",
                            pass.name, pass.lattice.size, pass.lattice.halo, size));
}

}  // namespace

void fused(Store& store, const FusedPass& pass, const FusedOptions& options) {
  check_pass(store, pass, options);
  const FusedNeeds needs = fused_needs(store, pass, options.threads);
  if (needs.frame_bytes > store.pager().budget_bytes())
    throw Error(ErrorCode::kBudget,
                fmt::format("fused '{}': {} bytes of blocks are filled at once by {} threads and "
                            "the budget is {}; a block holds {} bytes: raise the budget, take "
                            "smaller blocks or fewer threads",
                            pass.name, needs.frame_bytes, options.threads,
                            store.pager().budget_bytes(), store.options().block_bytes));
  store.pager().set_policy(EvictionPolicy::kWindow);

  FusedRun run(store, pass, options.threads);
  const std::uint64_t faces = store.base().face_count();
  {
    std::vector<std::jthread> helpers;
    for (int i = 1; i < options.threads; ++i) helpers.emplace_back([&run] { run.work([] {}); });
    run.work([&] {
      if (options.proceed && !options.proceed(run.schedule().faces_done(), faces))
        throw Error(ErrorCode::kCancelled, fmt::format("fused '{}': cancelled", pass.name));
    });
  }
  run.throw_error();
}

}  // namespace plait
