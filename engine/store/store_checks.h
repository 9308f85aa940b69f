// engine/store/store_checks.h: checks of what callers pass to the functions of Store.
#pragma once

#include <fmt/format.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "plait/error.h"
#include "store/store_state.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Errors: kInvalidArgument for a block size that no store can have.
inline void check_block_bytes(std::uint64_t block_bytes, std::string_view verb) {
  if (!std::has_single_bit(block_bytes) || block_bytes < 4096 || block_bytes > (1u << 30))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: block size {}, expected a power of two from 4096 to 2^30", verb,
                            block_bytes));
}

/// What a call does to a store.
enum class Change : std::uint8_t {
  kCommit,   ///< publishes what is there
  kRecords,  ///< changes records
  kAdd,      ///< adds attributes and levels, or changes what is known of them
  kRemove,   ///< removes what a walk over patches may have pinned
};

// In messages, `verb` is what the caller wants to do.

/// Errors: kBadState while a pass is under way that the change would disturb: the call comes from
/// one of its callbacks. kBusy while the store has readers or views.
void check_undisturbed(const Store::Implementation& state, Change change, std::string_view verb);

/// Errors: kNotSupported for a pipeline that stores no blocks because they are made, if the store
/// has depths.
void check_pipeline_of_depths(const Store::Implementation& state, const AttributeSchema& schema,
                              const Pipeline& pipeline);

/// Errors: those of check_undisturbed(); kBadState for a store that was opened for reading.
void check_change(const Store::Implementation& state, Change change, std::string_view verb);
/// The same; the change then begins.
void begin_change(Store::Implementation& state, Change change, std::string_view verb);

/// Errors: kBadState if blocks of another attribute are encoded from `needed`.
void check_not_needed(const Store::Implementation& state,
                      const Store::Implementation::Attribute& needed);

/// The reason for which records are unfinished, for messages.
std::string why_unfinished(const WrittenRecords& records);
/// Throws kBadState: nobody can read this level.
[[noreturn]] void refuse_unfinished(const Store::Implementation& state, std::string_view attribute,
                                    const WrittenRecords& records, int level);

/// Errors: kInvalidArgument for a number that is no attribute's.
template <class State>
auto& attribute_of(State& state, AttributeId attribute) {
  if (attribute >= state.attributes.size())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: expected an attribute below {}, found {}", state.name(),
                            state.attributes.size(), attribute));
  return state.attributes[attribute];
}

/// Errors: kInvalidArgument for an attribute or a level that is not there.
template <class State>
auto& level_of(State& state, AttributeId attribute, int level) {
  auto& data = attribute_of(state, attribute);
  const int first = state.provenance.base_level + 1, last = state.infos[attribute].finest_level;
  if (level < first || level > last)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("level {} of '{}': expected {} to {}", level,
                            state.infos[attribute].schema.name, first, last));
  return *data.levels[static_cast<std::size_t>(level - first)];
}

/// The record of whether the level is finished; the base records are level base_level(). Errors: as
/// level_of().
inline const WrittenRecords& written_records_of(const Store::Implementation& state,
                                                AttributeId attribute, int level) {
  if (level == state.provenance.base_level) return *attribute_of(state, attribute).base_written;
  return level_of(state, attribute, level);
}

PLAIT_END_NAMESPACE
