#include "derived/normals_of_positions.h"

#include <algorithm>
#include <cstdint>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "normals/normal_rules.h"
#include "plait/default_arithmetic.h"
#include "plait/edge_index.h"
#include "plait/kernels/edge_grid.h"
#include "plait/kernels/gather_grid.h"
#include "plait/kernels/ring_table.h"
#include "plait/level_cursor.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

using Normal = Vector3<float>;

/// The slots of positions around an edge, pinned. Levels count refinements of the base mesh.
template <class Point>
class PinnedSlots {
 public:
  explicit PinnedSlots(const DerivationSource& source)
      : source_(source), session_(source.pager->open_session()) {}

  /// Pins levels `first` to the finest one of all edges of the faces at `edge`, and level `own` of
  /// the edge itself. Keeps pins that the edge before had too. Errors: those of Session::pin.
  void pin_around(EdgeId edge, int first, int own) {
    wanted_.clear();
    const auto want = [&](int level, EdgeId of) {
      wanted_.emplace_back(
          level, source_.levels[static_cast<std::size_t>(level - 1)]->geometry.block_of(of));
    };
    const Edge& at = source_.mesh.edges[edge];
    for (const FaceSide side : {at.own, at.other})
      if (side.exists())
        for (const EdgeId of : source_.mesh.face_edges[side.face()])
          for (int level = first; level <= static_cast<int>(source_.levels.size()); ++level)
            want(level, of);
    want(own, edge);
    std::ranges::sort(wanted_);
    wanted_.erase(std::unique(wanted_.begin(), wanted_.end()), wanted_.end());
    if (wanted_ == blocks_) return;
    blocks_.clear();
    pins_.clear();
    requests_.clear();
    for (const auto& [level, block] : wanted_)
      requests_.emplace_back(*source_.levels[static_cast<std::size_t>(level - 1)], block);
    pins_.resize(requests_.size());
    session_.pin_many(requests_, pins_);
    blocks_ = wanted_;
  }

  std::span<const Point> slot(int level, EdgeId edge) const {
    const LevelGeometry& geometry = source_.levels[static_cast<std::size_t>(level - 1)]->geometry;
    const std::pair block(level, geometry.block_of(edge));
    const auto found = std::ranges::lower_bound(blocks_, block);
    const std::span<const std::byte> bytes =
        pins_[static_cast<std::size_t>(found - blocks_.begin())].bytes();
    const Slot at = geometry.slot(edge);
    const std::span<const std::byte> records =
        bytes.subspan(at.offset - geometry.block_offset(block.second), at.bytes);
    return {reinterpret_cast<const Point*>(records.data()), records.size() / sizeof(Point)};
  }

 private:
  using Block = std::pair<int, std::uint64_t>;

  const DerivationSource& source_;
  Session session_;
  std::vector<Block> wanted_, blocks_;  ///< (level, block), ascending
  std::vector<BlockRequest> requests_;
  std::vector<PinnedBlock> pins_;  ///< [as blocks_]
};

template <class Real>
class NormalsOfPositions final : public Deriver {
 public:
  explicit NormalsOfPositions(DerivationSource source)
      : source_(std::move(source)), finest_(static_cast<int>(source_.levels.size())) {}

  std::uint64_t scratch_bytes() const noexcept override {
    const std::uint64_t stride = (std::uint64_t{1} << finest_) + 3;
    return (stride * stride + 1) * sizeof(Point);
  }

  void make_base(std::span<std::byte> records) const override {
    const DefaultArithmetic arithmetic;
    RingTable<Point> rings(source_.mesh.edges.size());
    if (finest_ == 0) {
      rings.set_from_base(source_.mesh, base());
    } else {
      LevelCursor cursor(source_.pager->open_session(), *source_.levels.back());
      const std::int64_t last = slot_side(finest_) - 1;
      for (EdgeId edge = 0; edge < source_.mesh.edges.size(); ++edge) {
        const bool border = source_.mesh.edges[edge].is_border();
        const auto* const slot = reinterpret_cast<const Point*>(cursor.slot(edge).bytes.data());
        rings.set(edge, slot[slot_position(finest_, border, last, 0)],
                  slot[slot_position(finest_, border, 0, last)]);
      }
    }
    normals::base(source_.mesh, rings, base(),
                  {reinterpret_cast<Normal*>(records.data()), records.size() / sizeof(Normal)});
  }

  void make(const LevelGeometry& level, std::uint64_t block,
            std::span<std::byte> raw) const override {
    const DefaultArithmetic arithmetic;
    const int own = level.level().refinements;
    EdgeGrid<Point> grid = idle_grid();
    PinnedSlots<Point> slots(source_);
    const EdgeId after = level.edge_after(block);
    for (EdgeId edge = level.first_edge(block); edge < after; ++edge) {
      // All neighbours of a coarser vertex are vertices of the finest level.
      const int first = own == finest_ ? 1 : finest_;
      slots.pin_around(edge, first, own);
      gather(source_.mesh, slots, base(), edge, own == finest_ ? 0 : first, finest_, grid);
      auto* const to = reinterpret_cast<Normal*>(
          raw.subspan(level.slot(edge).offset - level.block_offset(block)).data());
      make_slot(grid, own, source_.mesh.edges[edge].is_border(), slots.slot(own, edge), to);
    }
    const std::scoped_lock lock(mutex_);
    grids_.push_back(std::move(grid));
  }

 private:
  using Point = Vector3<Real>;

  std::span<const Point> base() const {
    return {reinterpret_cast<const Point*>(source_.base.data()),
            source_.base.size() / sizeof(Point)};
  }

  /// A grid that no other call uses. A call that fails loses its grid, and the next one makes
  /// another.
  EdgeGrid<Point> idle_grid() const {
    {
      const std::scoped_lock lock(mutex_);
      if (!grids_.empty()) {
        EdgeGrid<Point> grid = std::move(grids_.back());
        grids_.pop_back();
        return grid;
      }
    }
    EdgeGrid<Point> grid;
    grid.resize(finest_);
    return grid;
  }

  /// `own` are the positions of the slot's vertices.
  void make_slot(const EdgeGrid<Point>& grid, int level, bool border, std::span<const Point> own,
                 Normal* to) const {
    const std::ptrdiff_t stride = grid.stride();
    const std::int64_t n = slot_side(level), scale = std::int64_t{1} << (finest_ - level);
    auto position = own.begin();
    for (std::int64_t row = 0; row < n; ++row) {
      const Point* v = grid.at((2 * row + 1) * scale, scale);
      const std::int64_t inside = border ? n - 1 - row : n;
      for (std::int64_t column = 0; column < inside; ++column, v += 2 * scale, ++position)
        *to++ =
            normals::regular(v[stride] - v[-stride], v[1] - v[-1], v[1 - stride] - v[stride - 1]);
      if (border)
        *to++ =
            normals::regular_border(*position++, v[1 - stride], v[-stride], v[-1], v[stride - 1]);
    }
  }

  DerivationSource source_;
  int finest_;
  mutable std::mutex mutex_;
  mutable std::vector<EdgeGrid<Point>> grids_;  ///< as many as calls were under way at once
};

}  // namespace

std::unique_ptr<Deriver> make_normals_of_positions(DerivationSource source) {
  if (source.schema.type == ComponentType::kFloat64)
    return std::make_unique<NormalsOfPositions<double>>(std::move(source));
  return std::make_unique<NormalsOfPositions<float>>(std::move(source));
}

PLAIT_END_NAMESPACE
