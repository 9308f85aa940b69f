#include "predicted/surface_maker.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <span>
#include <utility>

#include "base/default_arithmetic.h"
#include "fused/patch_lattice.h"
#include "plait/extend/block_makers.h"
#include "plait/extend/edge_index.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The memory of one call.
template <class Real>
struct SurfaceMaker<Real>::Workspace {
  explicit Workspace(const SurfaceMaker& maker)
      : refiner(make_refiner(maker.refinement_)), walk(maker.rule_) {}

  std::unique_ptr<PatchRefiner> refiner;
  RingWalk<Real> walk;
  std::vector<FaceId> faces;
};

/// Keeps the memory of one call for the next one, and frees that of calls at the same time.
template <class Real>
class SurfaceMaker<Real>::Lease {
 public:
  explicit Lease(const SurfaceMaker& maker) : maker_(maker) {
    {
      const std::scoped_lock lock(maker.mutex_);
      workspace_ = std::move(maker.idle_);
    }
    if (!workspace_) workspace_ = std::make_unique<Workspace>(maker);
  }
  ~Lease() {
    const std::scoped_lock lock(maker_.mutex_);
    if (!maker_.idle_) maker_.idle_ = std::move(workspace_);
  }
  Lease(const Lease&) = delete;
  Lease& operator=(const Lease&) = delete;
  Workspace& operator*() const { return *workspace_; }

 private:
  const SurfaceMaker& maker_;
  std::unique_ptr<Workspace> workspace_;
};

/// One side of the patches of a group: the lanes whose slot is in the block.
template <class Real>
struct SurfaceMaker<Real>::Side {
  struct Lane {
    std::uint8_t lane;
    std::size_t slot;  ///< offset in the block
  };
  struct Lanes {
    std::array<Lane, kPatchLanes> lanes;
    std::size_t count = 0;
    void add(std::size_t lane, std::size_t slot) {
      lanes[count++] = {static_cast<std::uint8_t>(lane), slot};
    }
    std::span<const Lane> all() const { return std::span(lanes).first(count); }
  };
  Lanes own, other, border;
  std::array<std::uint8_t, kPatchLanes> border_lanes{};
  bool any() const { return own.count + other.count + border.count > 0; }
};

template <class Real>
SurfaceMaker<Real>::SurfaceMaker(const OneRing<Real>& rule, const MadeLevel& level,
                                 MadeOutput output, int levels, std::uint32_t most_faces)
    : rule_(rule),
      geometry_(level.geometry),
      mesh_(level.surroundings.mesh),
      positions_(level.surroundings.positions),
      output_(output),
      level_(level.geometry.level().refinements),
      levels_(levels),
      most_faces_(most_faces),
      refinement_{{rule_, mesh_, {}, level_, {}, nullptr, level.surroundings.positions}, {}} {}

template <class Real>
SurfaceMaker<Real>::~SurfaceMaker() = default;

template <class Real>
std::uint64_t SurfaceMaker<Real>::scratch_bytes() const noexcept {
  // Vertices of one valence share batches of sixteen. At worst, each vertex of a run has a valence
  // of its own, until no other valence is left.
  const std::uint64_t most_spokes = most_faces_ + std::uint64_t{1};
  const std::uint64_t vertices = 3 * kRunFaces,
                      batches = std::min(vertices, 2 * most_spokes + vertices / kPatchLanes);
  const std::uint64_t rings = batches * (most_spokes + 1) * kPointNumbers * sizeof(Real) *
                              (static_cast<std::uint64_t>(level_) + 1);
  const std::uint64_t edges = std::uint64_t{1} << geometry_.slots_per_block_log2();
  return surface_scratch_bytes<Real>(level_, 1) + rings +
         vertices * (most_spokes * sizeof(VertexId) + 64) + 2 * edges * sizeof(FaceId) +
         sizeof(Workspace);
}

template <class Real>
void SurfaceMaker<Real>::find_faces(std::uint64_t block, std::vector<FaceId>& faces) const {
  faces.clear();
  const EdgeId after = geometry_.edge_after(block);
  for (EdgeId edge = geometry_.first_edge(block); edge < after; ++edge) {
    const Edge& at = mesh_.edges[edge];
    faces.push_back(at.own.face());
    if (!at.is_border()) faces.push_back(at.other.face());
  }
  std::ranges::sort(faces, std::ranges::greater());
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
}

/// Calls visit(bytes of a record in the block, its numbers) for every record; visit returns false
/// to end early. Returns false if it did.
template <class Real>
template <class Byte, class Visit>
bool SurfaceMaker<Real>::visit_block(std::uint64_t block, std::span<Byte> raw, Visit visit) const {
  const DefaultArithmetic arithmetic;  // whatever the program's own arithmetic is
  const Lease lease(*this);
  Workspace& work = *lease;
  find_faces(block, work.faces);
  for (std::size_t first = 0; first < work.faces.size(); first += kRunFaces) {
    const std::span<const FaceId> run =
        std::span(work.faces).subspan(first, std::min(kRunFaces, work.faces.size() - first));
    work.refiner->begin(run);
    for (std::size_t at = 0; at < run.size(); at += kPatchLanes) {
      const std::size_t count = std::min(kPatchLanes, run.size() - at);
      work.refiner->refine(at, count);
      if (!visit_group(work, run.subspan(at, count), block, raw, visit)) return false;
    }
  }
  return true;
}

template <class Real>
template <class Byte, class Visit>
bool SurfaceMaker<Real>::visit_group(Workspace& work, std::span<const FaceId> group,
                                     std::uint64_t block, std::span<Byte> raw, Visit& visit) const {
  const std::uint64_t begin = geometry_.block_offset(block);
  const EdgeId first = geometry_.first_edge(block), after = geometry_.edge_after(block);
  Sides sides;
  for (std::size_t lane = 0; lane < group.size(); ++lane) {
    const int turn = first_corner(mesh_, group[lane]);
    for (int number = 0; number < 3; ++number) {
      const FaceSide here(group[lane], (number + turn) % 3);
      const EdgeId edge = mesh_.face_edges[here.face()][static_cast<std::size_t>(here.side())];
      if (edge < first || edge >= after) continue;
      Side& side = sides[static_cast<std::size_t>(number)];
      const Slot at = geometry_.slot(edge);
      const std::size_t slot = at.offset - begin;
      if (at.shape == SlotShape::kHalf) {
        side.border_lanes[side.border.count] = static_cast<std::uint8_t>(lane);
        side.border.add(lane, slot);
      } else {
        (mesh_.edges[edge].own == here ? side.own : side.other).add(lane, slot);
      }
    }
  }

  const PatchLattice lattice = surface_lattice(level_, 1);
  const auto* const points = static_cast<const Real*>(work.refiner->points(0));
  const std::int64_t last = slot_side(level_) - 1;
  const auto visit_lanes = [&](std::span<const typename Side::Lane> lanes, std::int64_t position,
                               const auto* numbers) {
    const std::size_t record_bytes = geometry_.record_bytes();
    for (const auto& [lane, slot] : lanes)
      if (!visit(raw.data() + slot + static_cast<std::size_t>(position) * record_bytes,
                 lattice_points::get(numbers, lane)))
        return false;
    return true;
  };
  const auto visit_point = [&](const Side& side, const SideIndex& at, const auto* numbers) {
    const std::int64_t opposite =
        slot_position(level_, SlotShape::kWhole, last - at.row, last - at.column);
    return visit_lanes(side.own.all(), slot_position(level_, SlotShape::kWhole, at.row, at.column),
                       numbers) &&
           visit_lanes(side.border.all(),
                       slot_position(level_, SlotShape::kHalf, at.row, at.column), numbers) &&
           (at.row + at.column == last || visit_lanes(side.other.all(), opposite, numbers));
  };
  for (std::int64_t j = 0; j <= lattice.size; ++j)
    for (std::int64_t i = j % 2 == 0 ? 1 : 0; i + j <= lattice.size; i += j % 2 == 0 ? 2 : 1) {
      const SideIndex at = to_side(level_, i, j);
      const Side& side = sides[static_cast<std::size_t>(at.side)];
      if (!side.any()) continue;
      const bool on_side = at.row + at.column == last;
      work.walk.walk({points, lattice, i, j, at.side,
                      std::span(side.border_lanes).first(on_side ? side.border.count : 0)},
                     levels_ - level_);
      const bool goes_on =
          output_ == MadeOutput::kNormal  ? visit_point(side, at, work.walk.normal())
          : output_ == MadeOutput::kLimit ? visit_point(side, at, work.walk.limit())
                                          : visit_point(side, at, work.walk.v());
      if (!goes_on) return false;
    }
  return true;
}

template <class Real>
void SurfaceMaker<Real>::make(std::uint64_t block, SourceBytes, std::span<std::byte> raw) const {
  visit_block(block, raw, [](std::byte* record, const auto& numbers) {
    std::memcpy(record, &numbers, sizeof numbers);
    return true;
  });
}

template <class Real>
bool SurfaceMaker<Real>::makes(std::uint64_t block, SourceBytes,
                               std::span<const std::byte> raw) const {
  return visit_block(block, raw, [](const std::byte* record, const auto& numbers) {
    // The bits count: -0 and 0 differ, and a NaN equals itself.
    // NOLINTNEXTLINE(bugprone-suspicious-memory-comparison)
    return std::memcmp(record, &numbers, sizeof numbers) == 0;
  });
}

template <class Real>
bool SurfaceMaker<Real>::make_base(std::span<std::byte> records) const {
  if (levels_ > kMostMadeLevels) return false;
  const DefaultArithmetic arithmetic;
  const std::size_t vertices = mesh_.vertex_corners.size();
  std::vector<Vector3<Real>> positions(vertices), limits;
  std::vector<Vector3<float>> normals;
  if (output_ == MadeOutput::kNormal) normals.resize(vertices);
  if (output_ != MadeOutput::kPosition && rule_.has_limits()) limits.resize(vertices);
  const auto refiner = make_refiner(SurfaceRefinement<OneRing<Real>>{
      {rule_, mesh_, {}, levels_, {}, nullptr, positions_}, {positions, limits, normals}});
  std::vector<FaceId> run;
  for (auto after = static_cast<FaceId>(mesh_.faces.size()); after > 0;) {
    run.clear();
    while (after > 0 && run.size() < kRunFaces) run.push_back(--after);
    refiner->begin(run);
  }
  const void* const made = output_ == MadeOutput::kNormal ? static_cast<const void*>(normals.data())
                           : output_ == MadeOutput::kLimit ? limits.data()
                                                           : positions.data();
  std::memcpy(records.data(), made, records.size());
  return true;
}

template class SurfaceMaker<float>;
template class SurfaceMaker<double>;

PLAIT_END_NAMESPACE
