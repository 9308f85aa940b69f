#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "execution/pin_needs.h"
#include "plait/extend/base_relative_level.h"
#include "plait/extend/fused.h"
#include "plait/subdivide.h"
#include "schemes/table.h"
#include "subdivide/steps.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::size_t kNormalBytes = sizeof(Vector3<float>);

/// The largest need of the passes of sweep_steps.cpp. The passes at the finest level are the widest
/// of their kind.
std::uint64_t sweep_frame_bytes(const Store& store, const SubdivideOptions& options,
                                std::size_t record_bytes, bool makes_levels) {
  enum : AttributeId { kPosition, kNormal, kLimit };
  const int base_level = store.base_level(), last = options.levels;
  const SchemeTraits scheme = traits_of(options.scheme);
  std::uint64_t most = 0;
  const auto consider = [&](const std::vector<LevelAccess>& pass) {
    std::vector<AccessedLevels> accesses;
    accesses.reserve(pass.size());
    for (const LevelAccess& access : pass)
      accesses.push_back({access.attribute == kNormal ? kNormalBytes : record_bytes,
                          access.first_level, access.last_level, access.reach});
    most = std::max(most, sweep_needs(store, accesses, options.threads));
  };
  if (makes_levels) consider(odd_accesses(kPosition, base_level, last, scheme.ring_count));
  if (makes_levels && scheme.moves_even) consider(even_accesses(kPosition, base_level, last));
  if (options.normals || options.limit)
    consider(surface_accesses(kPosition, base_level, last,
                              options.normals ? AttributeId{kNormal} : kNoId,
                              options.limit ? AttributeId{kLimit} : kNoId));
  return most;
}

/// The same for transparent_steps.cpp. Passes over patches have half of the budget. The pass over
/// the finished surface has a quarter for each attribute, unless one face needs more.
std::uint64_t patch_frame_bytes(const Store& store, const SubdivideOptions& options,
                                std::size_t record_bytes, bool makes_levels) {
  const int first = store.base_level() + 1, last = options.levels;
  std::uint64_t most = 0;
  if (makes_levels)
    most = patch_needs(store,
                       {record_bytes, first, last,
                        traits_of(options.scheme).ring_count == 2 ? Reach::kRing : Reach::kFaces});
  if (!options.normals && !options.limit) return most;
  std::vector<std::uint64_t> windows = {
      patch_needs(store, {record_bytes, first, last, Reach::kFaces})};
  if (options.normals) windows.push_back(patch_needs(store, {kNormalBytes, first, last}));
  if (options.limit) windows.push_back(patch_needs(store, {record_bytes, first, last}));
  // The smallest budget in which all windows fit, if each has at least a quarter of the budget.
  // There are at most three windows, so the loop ends.
  for (std::uint64_t budget = 0;;) {
    std::uint64_t all = 0;
    for (const std::uint64_t window : windows) all += std::max(window, budget / 4);
    if (all <= budget) return std::max(most, budget);
    budget = all;
  }
}

std::size_t position_bytes(const Store& store) {
  return store.attributes()[store.attribute("position")].schema.record_bytes();
}

}  // namespace

std::uint64_t frames_of_subdivision(const Store& store, const SubdivideOptions& options,
                                    bool makes_levels) {
  const std::size_t record_bytes = position_bytes(store);
  if (options.executor == ExecutorKind::kSweep)
    return sweep_frame_bytes(store, options, record_bytes, makes_levels);
  if (options.executor == ExecutorKind::kTransparent)
    return patch_frame_bytes(store, options, record_bytes, makes_levels);
  const std::array<std::size_t, 2> records = {record_bytes, kNormalBytes};
  return fused_frame_bytes(store, std::span(records).first(options.normals ? 2 : 1), options.levels,
                           options.threads);
}

std::uint64_t resident_of_subdivision(const Store& store, const SubdivideOptions& options) {
  const std::uint64_t record_bytes = position_bytes(store);
  if (options.executor == ExecutorKind::kFused) {
    const auto bytes = [&]<class Rule>(const Rule&) {
      return fused_resident_bytes<Rule>(store, options);
    };
    return record_bytes == sizeof(Vector3<double>) ? with_rule<double>(options.scheme, bytes)
                                                   : with_rule<float>(options.scheme, bytes);
  }
  // A scheme of two rings has the rings of two levels in memory, and its extraordinary
  // values.
  const bool two_rings = traits_of(options.scheme).ring_count == 2;
  const std::uint64_t side =
      (std::uint64_t{1} << relative_to_base(options.levels, store.base_level()).refinements) + 3;
  return (2 * record_bytes * (two_rings ? 2 : 1) + (two_rings ? 48 : 0)) *
             store.base().edge_count() +
         static_cast<std::uint64_t>(options.threads) * side * side * record_bytes;
}

PLAIT_END_NAMESPACE
