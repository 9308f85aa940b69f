// plait/left_overs.h: what killed runs left under temporary names, NAME.partial-PID of outputs that
// were under way and STORE.repair-PID of repairs. Who makes one holds a lock on it (flock) that
// ends with the process, so what is not locked is nobody's.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "plait/directory.h"

namespace plait {

struct LeftOver {
  std::string name;  ///< in the directory that was looked at
  bool is_directory = false;
  bool in_use = false;               ///< somebody holds its lock: it is not left over, and stays
  std::uint64_t bytes = 0;           ///< of the files in it that plait made
  std::vector<std::string> foreign;  ///< of a directory: what is in it and not plait's, which stays
};

/// Sorted by name; with `of` only those on the way to that name. Errors: kIo.
std::vector<LeftOver> find_left_overs(const Directory& directory, std::string_view of = {});

/// Removes it, unless somebody has it by now; whether it is gone. Of a directory goes what plait
/// makes, and then the directory if nothing else was in it. Errors: kIo.
bool remove_left_over(const Directory& directory, const LeftOver& left_over);

/// Removes from a directory what plait makes under a temporary name: the files of a store, and
/// those of a repair. Errors: kIo.
void remove_made_files(const Directory& directory);

/// Removes what is left of earlier runs that made `path`, and tells `warn` of each.
/// Errors: kIo; those of OutputName.
void remove_left_overs_of(const std::filesystem::path& path,
                          const std::function<void(const std::string&)>& warn);

}  // namespace plait
