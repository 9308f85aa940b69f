#include "maintenance/compare_attribute.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>
#include <utility>

#include "maintenance/read_block.h"
#include "paging/level_cursor.h"
#include "plait/error.h"
#include "plait/extend/store_access.h"
#include "store/attribute_levels.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Whether the errors of all records are within `most`. A number that kept its bits has no error,
/// even if it is NaN.
template <class Number>
bool is_within(std::span<const std::byte> before, std::span<const std::byte> after,
               std::size_t components, ErrorMetric metric, long double most) {
  for (std::size_t at = 0; at < before.size(); at += components * sizeof(Number)) {
    long double sum = 0, largest = 0;
    for (std::size_t i = 0; i < components; ++i) {
      const auto bytes_before = before.subspan(at + i * sizeof(Number), sizeof(Number));
      const auto bytes_after = after.subspan(at + i * sizeof(Number), sizeof(Number));
      if (std::ranges::equal(bytes_before, bytes_after)) continue;
      Number from, to;
      std::memcpy(&from, bytes_before.data(), sizeof from);
      std::memcpy(&to, bytes_after.data(), sizeof to);
      const long double error =
          std::abs(static_cast<long double>(from) - static_cast<long double>(to));
      sum += error * error;
      largest = error <= largest ? largest : error;
    }
    const long double found = metric == ErrorMetric::kEuclidean ? std::sqrt(sum) : largest;
    if (!(found <= most)) return false;
  }
  return true;
}

}  // namespace

void compare_attribute(const Store& store, AttributeId attribute, const Store& of_copy,
                       AttributeId copy, const std::optional<ErrorBound>& bound,
                       const ProgressCallback& progress) try {
  const AttributeSchema& schema = store.attributes()[attribute].schema;
  const auto refuse = [&](int level, EdgeId edge) {
    return Error(ErrorCode::kCorruption,
                 fmt::format("read back {}: expected records of '{}' {} those of {}, found another "
                             "in the slot of edge {} of level {}",
                             of_copy.path().native(), schema.name,
                             bound ? "within the bound of" : "equal to", store.path().native(),
                             edge, level));
  };
  const auto base = store.base_bytes(attribute);
  if (!std::ranges::equal(base, of_copy.base_bytes(copy))) throw refuse(store.base_level(), 0);
  const Rounding rounding = bound ? Rounder(schema, *bound, base).result() : Rounding();
  const auto is_right = [&](std::span<const std::byte> before, std::span<const std::byte> after) {
    if (!bound) return std::ranges::equal(before, after);
    return schema.type == ComponentType::kFloat32
               ? is_within<float>(before, after, schema.components, rounding.metric, rounding.bound)
               : is_within<double>(before, after, schema.components, rounding.metric,
                                   rounding.bound);
  };
  const StorePass under_way(std::as_const(store));
  const auto edges = static_cast<EdgeId>(store.base().edge_count());
  const std::uint64_t total_bytes = bytes_of_levels(store, attribute);
  std::uint64_t done_bytes = 0;
  for (int level = store.base_level() + 1; level <= store.attributes()[attribute].finest_level;
       ++level) {
    const LevelFile& stored = StoreAccess::level_file(store, attribute, level);
    const LevelGeometry& geometry = stored.geometry;
    LevelCursor from(open_source_session(store, stored), stored);
    LevelCursor to(StoreAccess::open_session(of_copy),
                   StoreAccess::level_file(of_copy, copy, level));
    for (EdgeId edge = 0; edge < edges; ++edge) {
      if (!is_right(from.slot(edge).bytes, to.slot(edge).bytes)) throw refuse(level, edge);
      const std::uint64_t block = geometry.block_of(edge);
      if (edge + 1 != geometry.edge_after(block)) continue;
      done_bytes += geometry.block_bytes(block);
      if (progress && !progress({"compare", done_bytes, total_bytes}))
        throw Error(ErrorCode::kCancelled, "compare attribute: cancelled");
    }
  }
} catch (const std::bad_alloc&) {
  throw out_of_memory("compare attribute");
}

PLAIT_END_NAMESPACE
