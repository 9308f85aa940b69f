// plait/store_directory.h: which directories are stores, and which files in one are a store's: for
// programs that replace or remove stores and must touch nothing else.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "plait/directory.h"
#include "plait/file.h"

namespace plait {

/// Whether the directory's manifest says that it is a store: one of its slots is whole, of a
/// version of the format that is known or not. A store that was begun and never committed is one.
/// Errors: kIo; kCorruption if the manifest is no regular file.
bool is_store(const Directory& directory);

/// Keeps everybody else out of the store while the file is open, without a change to it; a file
/// that is not open where the store has no lock any more. Errors: kBusy, of a writer with its
/// process number; kCorruption, kIo.
File hold_store(const Directory& store);

/// Whether a store has files of such names.
bool is_store_file_name(std::string_view name);

/// Removes the files of a store, and nothing else, the manifest last. Returns the names of what
/// stays. REQUIRES: hold_store. Errors: kIo.
std::vector<std::string> remove_store_files(const Directory& store);

}  // namespace plait
