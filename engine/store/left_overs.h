// store/left_overs.h: finds and removes directories that killed runs of this machine left under
// unfinished names (io/unpublished.h). A process locks the directory that it makes (flock), and the
// lock ends with the process. So an unlocked one with the name of this machine is left over
// (may_be_in_use()), if it also proves that plait made it: names alone are no reason to remove
// anything.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/extend/directory.h"

PLAIT_BEGIN_NAMESPACE

/// Is told what the user should know. May be empty.
using Warn = std::function<void(const std::string&)>;

/// A directory that a killed process left under an unfinished name.
struct LeftOver {
  std::string name;  ///< in the directory that was searched
  /// A process has its lock, or another machine may work on it: remove_left_over() leaves it.
  bool in_use = false;
  std::uint64_t bytes = 0;           ///< of the files that plait made
  std::vector<std::string> foreign;  ///< entries that plait does not make; they stay
};

/// Finds left-overs, sorted by name: those of plait by their mark (io/made_mark.h) or the manifest
/// of a store in them, empty ones, and any that are locked. With `of`, only those that begin with
/// that stem (UnfinishedName::stem_of()). Errors: kIo.
std::vector<LeftOver> find_left_overs(const Directory& directory, std::string_view of = {});

/// Removes the left-over, unless another process has locked it meanwhile: the files that plait
/// makes, and then the directory if it is empty. Returns whether the left-over is removed. Errors:
/// kIo.
bool remove_left_over(const Directory& directory, const LeftOver& left_over);

/// Removes from a directory all files that plait makes in one with an unfinished name: those of a
/// store and those of a repair. If some cannot be removed, what proves that plait made the
/// directory stays too, so that the next attempt finds it. Errors: kIo.
void remove_made_files(const Directory& directory);

/// What a repair calls its directory inside the store, before it gets an unfinished name.
inline constexpr char kRepairStem[] = "scratch";

/// Removes what killed repairs of the store left in its directory (maintenance/repair.cpp), and
/// tells `warn` of each, and of what cannot be removed. Every writer of a store calls it.
void remove_left_overs_of_repairs(const Directory& store, const Warn& warn);

/// Removes the left-overs of killed runs whose output was `path`, and tells `warn` of each. Puts a
/// store back that a killed run left between two renames. Errors: kIo; those of OutputName.
void remove_left_overs_of(const std::filesystem::path& path, const Warn& warn);

PLAIT_END_NAMESPACE
