#include "prune/compare_pruned.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "maintenance/half_of_slot.h"
#include "paging/level_cursor.h"
#include "plait/detail/face_depths.h"
#include "plait/error.h"
#include "plait/extend/store_access.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

void check_same_mesh(const Store& pruned, const Store& whole) {
  if (pruned.base_level() == whole.base_level() &&
      std::ranges::equal(pruned.base().faces(), whole.base().faces()))
    return;
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("compare {} with {}: expected the same base mesh with its faces in the "
                          "same order",
                          pruned.path().native(), whole.path().native()));
}

/// Compares one level. Returns the first edge whose slot differs.
class LevelComparison {
 public:
  LevelComparison(const Store& pruned, const Store& whole, AttributeId id, AttributeId other,
                  int level)
      : mesh_(pruned.base().topology()),
        depths_(pruned.base().depths()),
        left_(StoreAccess::open_session(pruned), StoreAccess::level_file(pruned, id, level)),
        kept_(StoreAccess::open_session(whole), StoreAccess::level_file(whole, other, level)) {}

  /// False if the slot differs.
  bool is_equal(EdgeId edge, PrunedComparison& result) {
    const LocatedSlot slot = left_.slot(edge);
    if (slot.shape == SlotShape::kAbsent) return true;
    const LevelGeometry& geometry = left_.geometry();
    ++result.slots;
    result.records += slot.bytes.size() / geometry.record_bytes();
    const LocatedSlot whole = kept_.slot(edge);
    if (slot.shape == whole.shape) return std::ranges::equal(slot.bytes, whole.bytes);
    if (whole.shape != SlotShape::kWhole) return false;
    half_.resize(slot.bytes.size());
    copy_half_of_slot(whole.bytes, geometry.record_bytes(), geometry.level().refinements,
                      depths_->own_face_has(mesh_.edges[edge], geometry.level()), half_);
    return std::ranges::equal(slot.bytes, half_);
  }

 private:
  const Topology mesh_;
  const FaceDepths* depths_;
  LevelCursor left_, kept_;
  std::vector<std::byte> half_;
};

}  // namespace

PrunedComparison compare_pruned(const Store& pruned, const Store& whole,
                                const ProgressCallback& progress) {
  check_same_mesh(pruned, whole);
  const StorePass reading(pruned), reading_whole(whole);
  PrunedComparison result;
  const auto edges = static_cast<EdgeId>(pruned.base().edge_count());
  std::uint64_t done = 0, total = 0;
  for (const AttributeInfo& info : pruned.attributes())
    total += edges * static_cast<std::uint64_t>(info.finest_level - pruned.base_level());
  for (AttributeId id = 0; id < pruned.attributes().size(); ++id) {
    const AttributeSchema& schema = pruned.attributes()[id].schema;
    const int finest = pruned.attributes()[id].finest_level;
    const auto differ = [&](const std::string& where) {
      result.difference = fmt::format("attribute '{}' {}", schema.name, where);
      return result;
    };
    if (!whole.has_attribute(schema.name)) return differ("is in one of the stores only");
    const AttributeId other = whole.attribute(schema.name);
    if (whole.attributes()[other].schema != schema) return differ("has records of another type");
    if (whole.attributes()[other].finest_level < finest) return differ("has fewer levels there");
    if (!std::ranges::equal(pruned.base_bytes(id), whole.base_bytes(other)))
      return differ("differs at base vertices");
    result.records += pruned.base().vertex_count();
    for (int level = pruned.base_level() + 1; level <= finest; ++level) {
      StoreAccess::check_readable(pruned, id, level);
      StoreAccess::check_readable(whole, other, level);
      LevelComparison comparison(pruned, whole, id, other, level);
      for (EdgeId edge = 0; edge < edges; ++edge) {
        if (!comparison.is_equal(edge, result))
          return differ(fmt::format("differs in the slot of edge {} of level {}", edge, level));
        if (++done % 4096 == 0 && progress && !progress({"compare", done, total}))
          throw Error(ErrorCode::kCancelled, "compare: cancelled");
      }
    }
  }
  return result;
}

PLAIT_END_NAMESPACE
