#include "plait/copy_levels.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "plait/error.h"
#include "plait/level_cursor.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

void copy_attribute(Store& from, AttributeId attribute, Store& to, AttributeId copy,
                    const std::function<bool(std::uint64_t)>& proceed, Rounder* rounder) {
  const auto edges = static_cast<EdgeId>(from.base().edge_count());
  std::ranges::copy(std::as_const(from).base_bytes(attribute), to.base_bytes(copy).begin());
  const int finest = from.attributes()[attribute].finest_level;
  to.plan_levels(copy, finest, from.attributes()[attribute].schema.name);
  for (int level = from.base_level() + 1; level <= finest; ++level) {
    to.add_level(copy);
    const LevelGeometry& geometry = from.level_file(attribute, level).geometry;
    UnfinishedLevels written;
    written.add(to.level_file(copy, level), Access::kOverwrite);
    LevelCursor source(from.open_session(), from.level_file(attribute, level));
    LevelCursor target(to.open_session(), to.level_file(copy, level), Access::kOverwrite);
    for (EdgeId edge = 0; edge < edges; ++edge) {
      const std::span<std::byte> slot = target.slot(edge).bytes;
      std::ranges::copy(source.slot(edge).bytes, slot.begin());
      if (rounder != nullptr) rounder->round(slot);
      const std::uint64_t block = geometry.block_of(edge);
      if (edge + 1 != geometry.edge_after(block)) continue;
      if (proceed && !proceed(geometry.block_bytes(block)))
        throw Error(ErrorCode::kCancelled, "copy levels: cancelled");
    }
    written.finish();
  }
  const std::optional<Rounding>& earlier = from.rounding(attribute);
  to.set_rounding(copy, rounder != nullptr ? rounder->result(earlier) : earlier);
}

void copy_levels(Store& from, Store& to,
                 const std::function<bool(std::uint64_t, std::uint64_t)>& proceed,
                 const ErrorBounds& bounds) {
  to.set_provenance(from.provenance());
  std::uint64_t total_bytes = 0, done_bytes = 0;
  for (AttributeId id = 0; id < from.attributes().size(); ++id)
    for (int level = from.base_level() + 1; level <= from.attributes()[id].finest_level; ++level)
      total_bytes += from.level_file(id, level).geometry.total_bytes();
  for (AttributeId id = 0; id < from.attributes().size(); ++id) {
    const AttributeSchema& schema = from.attributes()[id].schema;
    std::optional<Rounder> rounder;
    if (const auto bound = bounds.of(schema.name))
      rounder.emplace(schema, *bound, std::as_const(from).base_bytes(id));
    copy_attribute(
        from, id, to, to.add_attribute(schema),
        [&](std::uint64_t copied) {
          done_bytes += copied;
          return !proceed || proceed(done_bytes, total_bytes);
        },
        rounder ? &*rounder : nullptr);
  }
  if (!bounds.of("position")) return;
  Provenance provenance = to.provenance();
  provenance.scheme.clear();  // it would make other positions
  to.set_provenance(provenance);
}

PLAIT_END_NAMESPACE
