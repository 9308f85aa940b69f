// engine/store/store_checks.h: checks of what callers pass to the functions of Store.
#pragma once

#include <fmt/format.h>

#include <cstddef>

#include "plait/error.h"
#include "store/store_state.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Errors: kBadState for a store that was opened for reading.
inline void check_writable(const Store::Implementation& state) {
  if (!state.writable)
    throw Error(ErrorCode::kBadState, fmt::format("{}: opened for reading", state.path.native()));
}

/// Errors: kInvalidArgument for a number that is no attribute's.
template <class State>
auto& attribute_of(State& state, AttributeId attribute) {
  if (attribute >= state.attributes.size())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: expected an attribute below {}, found {}", state.path.native(),
                            state.attributes.size(), attribute));
  return state.attributes[attribute];
}

/// Errors: kInvalidArgument for an attribute or a level that is not there.
template <class State>
auto& level_of(State& state, AttributeId attribute, int level) {
  auto& data = attribute_of(state, attribute);
  const int first = state.options.base_level + 1, last = state.infos[attribute].finest_level;
  if (level < first || level > last)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("level {} of '{}': expected {} to {}", level,
                            state.infos[attribute].schema.name, first, last));
  return *data.levels[static_cast<std::size_t>(level - first)];
}

PLAIT_END_NAMESPACE
