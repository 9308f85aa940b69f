#include "predicted/normals_maker.h"

#include <fmt/format.h>

#include <cstring>
#include <mutex>
#include <utility>

#include "base/default_arithmetic.h"
#include "plait/error.h"
#include "plait/extend/block_makers.h"
#include "plait/extend/edge_index.h"
#include "predicted/slot_normals.h"
#include "predicted/source_slots.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

using Normal = Vector3<float>;

template <class Real>
class NormalsMaker final : public BlockMaker {
 public:
  NormalsMaker(const MadeLevel& level, const AttributeLevels& source, int finest)
      : geometry_(level.geometry),
        attribute_(source.number),
        base_level_(level.surroundings.base_level),
        base_(source.base),
        // All neighbours of a coarser vertex are vertices of the finest level.
        blocks_(level.surroundings.mesh, {source.levels.begin(), source.levels.begin() + finest},
                own() == finest ? 1 : finest, own()) {}

  std::uint64_t scratch_bytes() const noexcept override {
    return sizeof(Workspace) + SlotNormals<Real>::memory_bytes(own(), finest()) +
           slot_records(own()) * sizeof(Normal);
  }

  std::uint32_t source_attribute() const noexcept override { return attribute_; }
  std::size_t sources(std::uint64_t block,
                      std::span<ContextBlock, kMostContextBlocks> blocks) const noexcept override {
    const SourceBlocks::Choice choice = choose(block);
    for (std::size_t i = 0; i < choice.count; ++i)
      blocks[i] = {attribute_, base_level_ + choice.blocks[i].level, choice.blocks[i].block};
    return choice.count;
  }

  void make(std::uint64_t block, SourceBytes sources, std::span<std::byte> raw) const override {
    const bool made = visit_slots(block, sources, [&](const Slot& at, auto fill, Normal*) {
      fill(reinterpret_cast<Normal*>(raw.data() + at.offset));
      return true;
    });
    if (!made)
      throw Error(ErrorCode::kNotSupported,
                  fmt::format("make block {} of normals: expected the blocks of positions around "
                              "it, found {} blocks",
                              block, sources.size()));
  }

  bool makes(std::uint64_t block, SourceBytes sources,
             std::span<const std::byte> raw) const override {
    return visit_slots(block, sources, [&](const Slot& at, auto fill, Normal* slot) {
      fill(slot);
      // The bits count: -0 and 0 differ, and a NaN equals itself.
      return std::memcmp(slot, raw.data() + at.offset, at.bytes) == 0;
    });
  }

 private:
  using Point = Vector3<Real>;
  /// The memory of one call.
  struct Workspace {
    SlotNormals<Real> normals;
    std::vector<Normal> slot;
  };

  int own() const { return geometry_.level().refinements; }
  int finest() const { return blocks_.finest(); }
  SourceBlocks::Choice choose(std::uint64_t block) const noexcept {
    return blocks_.choose(geometry_.first_edge(block), geometry_.edge_after(block));
  }
  std::span<const Point> base() const {
    return {reinterpret_cast<const Point*>(base_.data()), base_.size() / sizeof(Point)};
  }

  /// Calls visit(slot, fill, spare) for each slot of the block: its place in the block, a function
  /// that writes its normals, and memory for them. visit() returns false to end early. Returns
  /// false if it did, and if `sources` are not those of the block.
  template <class Visit>
  bool visit_slots(std::uint64_t block, SourceBytes sources, Visit visit) const {
    const SourceBlocks::Choice choice = choose(block);
    if (choice.count == 0 || choice.count != sources.size()) return false;
    const DefaultArithmetic arithmetic;  // whatever the program's own arithmetic is
    const SourceSlots<Point> slots(blocks_, choice, sources);
    std::unique_ptr<Workspace> work = idle_workspace();
    bool goes_on = true;
    const EdgeId after = geometry_.edge_after(block);
    for (EdgeId edge = geometry_.first_edge(block); edge < after && goes_on; ++edge) {
      if (edge + 1 < after) work->normals.prefetch(blocks_.mesh(), slots, edge + 1);
      Slot slot = geometry_.slot(edge);
      slot.offset -= geometry_.block_offset(block);
      const auto fill = [&](Normal* to) {
        work->normals.compute(blocks_.mesh(), slots, base(), edge, to);
      };
      goes_on = visit(slot, fill, work->slot.data());
    }
    const std::scoped_lock lock(mutex_);
    if (!idle_) idle_ = std::move(work);
    return goes_on;
  }

  /// Memory that no other call uses. A call that fails loses it, and the next one makes other.
  std::unique_ptr<Workspace> idle_workspace() const {
    {
      const std::scoped_lock lock(mutex_);
      if (idle_) return std::move(idle_);
    }
    return std::make_unique<Workspace>(
        Workspace{{own(), finest()}, std::vector<Normal>(slot_records(own()))});
  }

  const LevelGeometry& geometry_;
  std::uint32_t attribute_;
  int base_level_;
  std::span<const std::byte> base_;
  SourceBlocks blocks_;
  mutable std::mutex mutex_;
  mutable std::unique_ptr<Workspace> idle_;  ///< of the last call
};

}  // namespace

std::unique_ptr<BlockMaker> make_normals_maker(const RecipeSource& source, const MadeLevel& level) {
  const auto& attributes = level.surroundings.attributes;
  const auto found = std::ranges::find_if(attributes, [&](const AttributeLevels& each) {
    return each.schema.name == source.attribute && each.number < level.attribute;
  });
  if (found == attributes.end() || found->schema.components != 3 ||
      level.schema.type != ComponentType::kFloat32 || level.schema.components != 3 ||
      found->levels.size() < static_cast<std::size_t>(source.levels) ||
      level.geometry.level().refinements > source.levels || source.levels > kMostMadeLevels)
    return nullptr;
  if (found->schema.type == ComponentType::kFloat32)
    return std::make_unique<NormalsMaker<float>>(level, *found, source.levels);
  if (found->schema.type == ComponentType::kFloat64)
    return std::make_unique<NormalsMaker<double>>(level, *found, source.levels);
  return nullptr;
}

PLAIT_END_NAMESPACE
