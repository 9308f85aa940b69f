#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <list>

#include "paging/frame_pool.h"
#include "plait/error.h"
#include "plait/patch.h"

namespace plait {

struct PatchWindow::Pins {
  Session session;
  struct Pin {
    std::size_t level;
    std::uint64_t block;
    PinnedBlock pinned;
  };
  std::list<Pin> in_order;  ///< of pinning: the first goes first
  std::vector<std::vector<std::uint32_t>>
      used_by;                 ///< [refinements][block] last face that needs it, + 1
  std::vector<Access> access;  ///< [refinements]
  std::uint32_t stamp = 0;     ///< of the current face
  std::uint64_t window_bytes = 0, pinned_bytes = 0;
  int exceptions = std::uncaught_exceptions();  ///< when the window was made

  std::vector<LevelFile*> written;

  ~Pins() {
    if (std::uncaught_exceptions() == exceptions) return;
    // An exception that passes by ends the work in the middle of a pass.
    for (LevelFile* const level : written) level->left_unfinished = true;
    for (Pin& pin : in_order) pin.pinned.abandon();
  }

  std::uint64_t frame_bytes(const PatchWindow& window, std::size_t level) const {
    return FramePool::frame_bytes(window.levels_[level].file->geometry.max_block_bytes());
  }
};

PatchWindow::PatchWindow(Store& store, AttributeId attribute, Reach reach,
                         std::uint64_t window_bytes)
    : store_(&store),
      attribute_(attribute),
      reach_(reach),
      topology_(store.base().topology()),
      record_bytes_(store.attributes()[attribute].schema.record_bytes()),
      pins_(std::make_unique<Pins>()) {
  pins_->window_bytes = window_bytes;
}

PatchWindow::~PatchWindow() = default;

void PatchWindow::activate(int readable, int first_writable, int last_writable) {
  const int base_level = store_->base_level();
  const int finest = store_->attributes()[attribute_].finest_level;
  if (readable < base_level || readable > finest)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("activate level {} of '{}': expected {} to {}", readable,
                            store_->attributes()[attribute_].schema.name, base_level, finest));
  const auto writable = [&](int level) {
    return level >= first_writable && level <= last_writable;
  };
  for (int level = base_level + 1; level <= readable; ++level)
    if (writable(level) && !store_->level_file(attribute_, level).writable)
      throw Error(
          ErrorCode::kBadState,
          fmt::format("activate level {} of '{}' for writing: {} was opened for reading", level,
                      store_->attributes()[attribute_].schema.name, store_->path().native()));
  pins_->in_order.clear();
  pins_->written.clear();
  pins_->pinned_bytes = 0;
  pins_->used_by.clear();
  pins_->access.clear();
  levels_.assign(1, Level{});
  pins_->used_by.emplace_back();
  pins_->access.push_back(Access::kRead);
  for (int level = base_level + 1; level <= readable; ++level) {
    LevelFile& file = store_->level_file(attribute_, level);
    levels_.push_back({&file, std::vector<std::uintptr_t>(file.geometry.block_count(), 0)});
    pins_->used_by.emplace_back(file.geometry.block_count(), 0);
    pins_->access.push_back(writable(level) ? Access::kUpdate : Access::kRead);
    if (writable(level)) pins_->written.push_back(&file);
  }
  table_.set_levels(base_level, relative_to_base(readable, base_level));
  pins_->session = store_->open_session();
}

void PatchWindow::need(EdgeId edge) {
  const std::uint32_t stamp = pins_->stamp;
  for (std::size_t number = 1; number < levels_.size(); ++number) {
    Level& level = levels_[number];
    const LevelGeometry& geometry = level.file->geometry;
    const std::uint64_t block = geometry.block_of(edge);
    pins_->used_by[number][block] = stamp;
    if (level.starts[block] != 0) continue;
    const std::uint64_t bytes = pins_->frame_bytes(*this, number);
    for (auto pin = pins_->in_order.begin();
         pin != pins_->in_order.end() && pins_->pinned_bytes + bytes > pins_->window_bytes;) {
      if (pins_->used_by[pin->level][pin->block] == stamp) {
        ++pin;
        continue;
      }
      levels_[pin->level].starts[pin->block] = 0;
      pins_->pinned_bytes -= pins_->frame_bytes(*this, pin->level);
      pin = pins_->in_order.erase(pin);
    }
    pins_->in_order.push_back(
        {number, block, pins_->session.pin(*level.file, block, pins_->access[number])});
    level.starts[block] =
        reinterpret_cast<std::uintptr_t>(pins_->in_order.back().pinned.bytes().data()) -
        geometry.block_offset(block);
    pins_->pinned_bytes += bytes;
  }
}

std::byte* PatchWindow::pinned_slot(BaseRelativeLevel level, EdgeId edge) const {
  const Level& at = levels_[static_cast<std::size_t>(level.refinements)];
  if (at.starts[at.file->geometry.block_of(edge)] == 0)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("face {} of '{}': the point is beyond the reach of the patch",
                            table_.face(), store_->attributes()[attribute_].schema.name));
  return slot(level, edge, topology_.border_rank(edge));
}

void PatchWindow::enter(FaceId face) {
  pins_->stamp = face + 1;
  for (const EdgeId edge : topology_.face_edges[face]) need(edge);
  for (int side = 0; side < 3 && reach_ != Reach::kOwn; ++side) {
    const FaceSide beyond = topology_.across(FaceSide(face, side));
    if (!beyond.exists()) continue;
    for (int turn = 1; turn <= 2; ++turn) {
      const FaceSide outer(beyond.face(), (beyond.side() + turn) % 3);
      need(topology_.face_edges[outer.face()][static_cast<std::size_t>(outer.side())]);
      const FaceSide further = reach_ == Reach::kRing ? topology_.across(outer) : FaceSide();
      if (!further.exists()) continue;
      for (const EdgeId edge : topology_.face_edges[further.face()]) need(edge);
    }
  }
  EdgeId ranked = kNoId;
  std::uint64_t rank = 0;
  table_.enter(topology_, face, record_bytes_, true, reach_ != Reach::kOwn,
               store_->base_bytes(attribute_).data(), [&](EdgeId edge, BaseRelativeLevel level) {
                 if (edge != ranked) rank = topology_.border_rank(ranked = edge);
                 return slot(level, edge, rank);
               });
}

}  // namespace plait
