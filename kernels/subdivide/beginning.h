// Where a subdivision begins, what refuses it before its first change, and the way back after an
// error.
#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <string>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/extend/provenance.h"
#include "plait/store.h"
#include "plait/subdivide.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The finest level of positions that a subdivision by this scheme keeps. Unfinished levels are
/// made again: alone if the scheme moves no coarser vertices, otherwise together with all levels
/// before them. REQUIRES: attribute "position".
int finest_kept_level(const Store& store, const Scheme& scheme);

/// The state of a store before a subdivision. Threads: one.
class Beginning {
 public:
  /// Changes nothing. Errors: those that subdivide() has before its first change.
  Beginning(Store& store, const SubdivideOptions& options);

  /// Removes what an earlier call left unfinished.
  void clear_away();
  /// The finest level of positions that stays.
  int level() const noexcept { return level_; }
  /// Throws kBudget if the frames of the whole work do not fit. The store knows what its backend
  /// keeps of the budget when it has a level.
  void check_budget() const;
  /// Adds an attribute without levels. `name` is in the store until the work has ended.
  AttributeId add(const AttributeSchema& schema);

  /// After an error of the work. If it has left levels of positions unfinished, their base records
  /// are then as before. With `everything`, all else is, too, as far as that can be.
  void undo(bool everything) noexcept;
  /// After success.
  void finish(bool limit) noexcept;

 private:
  AttributeId position() const { return store_.attribute("position"); }
  std::vector<std::byte>& records_before_levels() const;
  void set_base_records(const std::vector<std::byte>& records);
  /// Throws kBadState if blocks of new positions are encoded from what the work changes later.
  void check_pipelines() const;

  Store& store_;
  const SubdivideOptions& options_;
  const int level_;
  const int there_;  ///< the finest level, finished or not
  const std::uint64_t sequence_;
  const Provenance provenance_;
  std::vector<std::string> added_;  ///< attributes
  std::vector<std::byte> records_;  ///< base records of positions at the beginning
  /// The same before the levels were made; empty if they are not known.
  std::vector<std::byte> before_levels_;
};

/// Throws kBudget for a subdivision whose whole work needs `frame_bytes`.
[[noreturn]] void refuse_budget(const Store& store, const SubdivideOptions& options,
                                std::uint64_t frame_bytes, const char* reason);

PLAIT_END_NAMESPACE
