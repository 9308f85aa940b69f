#include "plait/copy_levels.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "maintenance/source_session.h"
#include "plait/attribute_levels.h"
#include "plait/derivation.h"
#include "plait/error.h"
#include "plait/level_cursor.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

namespace {

using Proceed = std::function<bool(std::uint64_t copied)>;

/// Adds the levels of a derived attribute, and compares their records with those of `attribute`, if
/// wanted.
class DerivedCopy {
 public:
  DerivedCopy(Store& from, AttributeId attribute, Store& to, AttributeId copy,
              const Proceed& proceed)
      : from_(from), attribute_(attribute), to_(to), copy_(copy), proceed_(proceed) {}

  void add_levels() {
    while (to_.attributes()[copy_].finest_level < from_.attributes()[attribute_].finest_level)
      to_.add_level(copy_);
  }

  void compare() {
    if (!std::ranges::equal(std::as_const(from_).base_bytes(attribute_),
                            std::as_const(to_).base_bytes(copy_)))
      refuse("a base vertex");
    const int finest = from_.attributes()[attribute_].finest_level;
    for (int level = from_.base_level() + 1; level <= finest; ++level) compare(level);
  }

 private:
  void compare(int level) {
    const auto edges = static_cast<EdgeId>(from_.base().edge_count());
    const LevelFile& stored = from_.level_file(attribute_, level);
    const LevelGeometry& geometry = stored.geometry;
    LevelCursor expected(open_source_session(from_, stored), stored);
    LevelCursor found(to_.open_session(), to_.level_file(copy_, level));
    for (EdgeId edge = 0; edge < edges; ++edge) {
      if (!std::ranges::equal(expected.slot(edge).bytes, found.slot(edge).bytes))
        refuse(fmt::format("edge {} of level {}", edge, level));
      const std::uint64_t block = geometry.block_of(edge);
      if (edge + 1 != geometry.edge_after(block)) continue;
      if (proceed_ && !proceed_(geometry.block_bytes(block)))
        throw Error(ErrorCode::kCancelled, "copy levels: cancelled");
    }
  }

  [[noreturn]] void refuse(const std::string& where) {
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("derive '{}' as {}: expected the records that are stored, found others "
                    "at {}; keep the attribute stored",
                    from_.attributes()[attribute_].schema.name, to_.derivation(copy_), where));
  }

  Store& from_;
  AttributeId attribute_;
  Store& to_;
  AttributeId copy_;
  const Proceed& proceed_;
};

[[noreturn]] void refuse_rounding(const Store& store, AttributeId attribute) {
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("round '{}': it is computed from another attribute, expected one that is "
                          "stored",
                          store.attributes()[attribute].schema.name));
}

/// The attribute that a derived one is computed from.
std::string_view source_of(std::string_view derivation) {
  return derivation.substr(derivation.find('/') + 1);
}

}  // namespace

void copy_attribute(Store& from, AttributeId attribute, Store& to, AttributeId copy,
                    const std::function<bool(std::uint64_t)>& proceed, Rounder* rounder) {
  if (!to.derivation(copy).empty()) {
    if (rounder != nullptr) refuse_rounding(to, copy);
    DerivedCopy derived(from, attribute, to, copy, proceed);
    derived.add_levels();
    // The same rule makes the same records of the same source.
    if (from.derivation(attribute) != to.derivation(copy)) derived.compare();
    return;
  }
  const auto edges = static_cast<EdgeId>(from.base().edge_count());
  std::ranges::copy(std::as_const(from).base_bytes(attribute), to.base_bytes(copy).begin());
  const int finest = from.attributes()[attribute].finest_level;
  to.plan_levels(copy, finest, from.attributes()[attribute].schema.name);
  for (int level = from.base_level() + 1; level <= finest; ++level) {
    to.add_level(copy);
    const LevelFile& stored = from.level_file(attribute, level);
    const LevelGeometry& geometry = stored.geometry;
    UnfinishedLevels written;
    written.add(to.level_file(copy, level), Access::kOverwrite);
    LevelCursor source(open_source_session(from, stored), stored);
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
    total_bytes += bytes_of_levels(from, id);
  const auto count = [&](std::uint64_t copied) {
    done_bytes += copied;
    return !proceed || proceed(done_bytes, total_bytes);
  };
  std::vector<AttributeId> copies;
  for (AttributeId id = 0; id < from.attributes().size(); ++id) {
    copies.push_back(to.add_attribute(from.attributes()[id].schema));
    if (!from.derivation(id).empty() && !to.options().pipeline_of)
      to.set_pipeline(copies.back(), derived_pipeline(from.derivation(id)));
  }
  // Attributes that are computed come after what they are computed from.
  for (const bool derived : {false, true})
    for (AttributeId id = 0; id < from.attributes().size(); ++id) {
      const AttributeSchema& schema = from.attributes()[id].schema;
      const std::string_view derivation = to.derivation(copies[id]);
      if (derivation.empty() == derived) continue;
      if (derived && !bounds.of(schema.name) && bounds.of(source_of(derivation))) {
        DerivedCopy(from, id, to, copies[id], count).add_levels();
        continue;
      }
      std::optional<Rounder> rounder;
      if (const auto bound = bounds.of(schema.name)) {
        if (derived) refuse_rounding(from, id);
        rounder.emplace(schema, *bound, std::as_const(from).base_bytes(id));
      }
      copy_attribute(from, id, to, copies[id], count, rounder ? &*rounder : nullptr);
    }
  if (!bounds.of("position")) return;
  Provenance provenance = to.provenance();
  provenance.scheme.clear();  // it would make other positions
  to.set_provenance(provenance);
}

PLAIT_END_NAMESPACE
