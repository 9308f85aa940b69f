#include "plait/extend/copy_levels.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <deque>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "maintenance/half_of_slot.h"
#include "maintenance/read_block.h"
#include "paging/level_cursor.h"
#include "plait/detail/face_depths.h"
#include "plait/error.h"
#include "plait/extend/store_access.h"
#include "plait/notes.h"
#include "store/attribute_levels.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

namespace {

/// Whether blocks of the level are encoded from other levels of its own attribute.
bool needs_own_levels(const LevelFile& level) {
  if (!needs_other_blocks(level)) return false;
  std::array<ContextBlock, kMostContextBlocks> needed;
  const std::size_t count = level.backend->context(0, needed);
  return std::ranges::any_of(std::span(needed).first(count), [&](const ContextBlock& block) {
    return block.attribute == level.table.attribute();
  });
}

/// Whether all levels shall be copied in one pass. Blocks of another attribute, from which the
/// source or the copy makes blocks of several levels, are then read once. Levels that are encoded
/// from each other are written one after another.
bool can_be_copied_together(Store& from, AttributeId attribute, Store& to, AttributeId copy) {
  const int finest = to.attributes()[copy].finest_level;
  if (finest == from.base_level()) return false;
  for (int level = from.base_level() + 1; level <= finest; ++level) {
    const LevelFile& stored = StoreAccess::level_file(from, attribute, level);
    const LevelFile& written = StoreAccess::level_file(to, copy, level);
    if (!needs_other_blocks(stored) && !needs_other_blocks(written)) return false;
    if (needs_own_levels(stored) || needs_own_levels(written)) return false;
  }
  return true;
}

/// A level that is being copied.
struct CopiedLevel {
  CopiedLevel(const std::shared_ptr<Session>& reading, const LevelFile& stored,
              const std::shared_ptr<Session>& writing, LevelFile& copy)
      : geometry(stored.geometry),
        source(reading, stored),
        target(writing, copy, Access::kOverwrite) {
    written.add(copy, Access::kOverwrite);
  }
  /// Copies what the target's faces have of a slot.
  void copy(EdgeId edge, const BaseMesh& base, std::span<std::byte> to) {
    if (to.empty()) return;
    const std::span<const std::byte> from = source.slot(edge).bytes;
    if (from.size() == to.size()) {
      std::ranges::copy(from, to.begin());
      return;
    }
    const BaseRelativeLevel level = geometry.level();
    copy_half_of_slot(from, geometry.record_bytes(), level.refinements,
                      base.depths()->own_face_has(base.arrays().mesh.edges[edge], level), to);
  }
  const LevelGeometry& geometry;
  UnfinishedLevels written;
  LevelCursor source, target;
};

/// No deeper than a face of `to`.
int finest_copied(const Store& from, AttributeId attribute, const Store& to) {
  const int finest = from.attributes()[attribute].finest_level;
  const FaceDepths* const depths = to.base().depths();
  return depths == nullptr ? finest : std::min(finest, to.base_level() + depths->deepest());
}

/// Whether each face of `to` has at most the levels that `from` has. With the same edges.
void check_depths(const Store& from, const Store& to) {
  const FaceDepths* const had = from.base().depths();
  const FaceDepths* const wanted = to.base().depths();
  for (FaceId face = 0; had != nullptr && face < from.base().face_count(); ++face)
    if (wanted == nullptr || wanted->of(face) > had->of(face))
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("copy levels: face {}: expected a depth of at most {}, as in {}",
                              face, from.base_level() + had->of(face), from.path().native()));
}

}  // namespace

void copy_attribute(Store& from, AttributeId attribute, Store& to, AttributeId copy,
                    const ProgressCallback& progress, Rounder* rounder, bool changes_later) try {
  for (int level = from.base_level(); level <= from.attributes()[attribute].finest_level; ++level)
    StoreAccess::check_readable(from, attribute, level);
  check_depths(from, to);
  const auto edges = static_cast<EdgeId>(from.base().edge_count());
  const std::uint64_t total_bytes = bytes_of_levels(from, attribute);
  std::uint64_t done_bytes = 0;
  std::ranges::copy(std::as_const(from).base_bytes(attribute), to.base_bytes(copy).begin());
  const int finest = finest_copied(from, attribute, to);
  StoreAccess::plan_levels(to, copy, finest, true);
  const int first = from.base_level() + 1;
  for (int level = first; level <= finest; ++level)
    changes_later ? to.add_level(copy) : StoreAccess::add_final_level(to, copy);
  const auto copy_levels_of = [&](int coarsest, int last) {
    std::optional<StorePass> reading;
    if (&from != &to) reading.emplace(std::as_const(from));
    const StorePass writing(to, "copy levels to");
    const auto reader = std::make_shared<Session>(
        open_source_session(from, StoreAccess::level_file(from, attribute, last)));
    const auto writer =
        std::make_shared<Session>(StoreAccess::open_session(to, {.only_writes = true}));
    std::deque<CopiedLevel> levels;
    for (int level = coarsest; level <= last; ++level)
      levels.emplace_back(reader, StoreAccess::level_file(from, attribute, level), writer,
                          StoreAccess::level_file(to, copy, level));
    for (EdgeId edge = 0; edge < edges; ++edge)
      for (CopiedLevel& level : levels) {
        const std::span<std::byte> slot = level.target.slot(edge).bytes;
        level.copy(edge, to.base(), slot);
        if (rounder != nullptr) rounder->round(slot);
        const std::uint64_t block = level.geometry.block_of(edge);
        if (edge + 1 != level.geometry.edge_after(block)) continue;
        done_bytes += level.geometry.block_bytes(block);
        if (progress && !progress({"copy", done_bytes, total_bytes}))
          throw Error(ErrorCode::kCancelled, "copy levels: cancelled");
      }
    for (CopiedLevel& level : levels) level.written.finish();
  };
  if (rounder != nullptr || !can_be_copied_together(from, attribute, to, copy)) {
    for (int level = first; level <= finest; ++level) copy_levels_of(level, level);
  } else {
    try {
      copy_levels_of(first, finest);
    } catch (const Error& error) {
      // So many blocks at once, each with its context, are more than the budget holds.
      if (error.code() != ErrorCode::kBudget) throw;
      done_bytes = 0;
      for (int level = first; level <= finest; ++level) copy_levels_of(level, level);
    }
  }
  const std::optional<Rounding>& earlier = StoreAccess::rounding(from, attribute);
  StoreAccess::set_rounding(to, copy, rounder != nullptr ? rounder->result(earlier) : earlier);
} catch (const std::bad_alloc&) {
  throw out_of_memory("copy levels");
}

void copy_notes(const Store& from, Store& to) {
  for (const auto& [name, text] : from.notes().texts()) to.notes().set_text(name, text);
  for (const AttributeSchema& schema : from.notes().face_attributes()) {
    to.notes().add_face_attribute(schema);
    std::ranges::copy(from.notes().face_bytes(schema.name),
                      to.notes().face_bytes(schema.name).begin());
  }
}

void copy_levels(Store& from, Store& to, const ProgressCallback& progress,
                 const ErrorBounds& bounds, bool changes_later) try {
  StoreAccess::set_provenance(to, from.provenance());
  std::uint64_t total_bytes = 0, done_bytes = 0;
  for (AttributeId id = 0; id < from.attributes().size(); ++id)
    total_bytes += bytes_of_levels(from, id);
  const ProgressCallback count = [&](const Progress& now) {
    return !progress || progress({now.phase, done_bytes + now.done, total_bytes});
  };
  copy_notes(from, to);
  std::vector<AttributeId> copies;
  for (const AttributeInfo& info : from.attributes())
    copies.push_back(to.add_attribute(info.schema));
  for (AttributeId id = 0; id < from.attributes().size(); ++id) {
    const AttributeSchema& schema = from.attributes()[id].schema;
    std::optional<Rounder> rounder;
    if (const auto bound = bounds.of(schema.name))
      rounder.emplace(schema, *bound, std::as_const(from).base_bytes(id));
    copy_attribute(from, id, to, copies[id], count, rounder ? &*rounder : nullptr, changes_later);
    done_bytes += bytes_of_levels(from, id);
  }
  if (!bounds.of("position")) return;
  Provenance provenance = to.provenance();
  provenance.scheme.clear();  // it would make other positions
  StoreAccess::set_provenance(to, provenance);
} catch (const std::bad_alloc&) {
  throw out_of_memory("copy levels");
}

PLAIT_END_NAMESPACE
