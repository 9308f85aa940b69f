// store/store_directory.h: tells which directories are stores, and which files in such a directory
// belong to the store. Programs that replace or remove stores use it, so that they touch no other
// file.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/extend/directory.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_NAMESPACE

/// Whether the directory is a store: whether its manifest has a slot with a valid checksum, of any
/// version of the format. A store that was created but never committed counts.
/// Errors: kIo; kCorruption if the manifest is no regular file.
bool is_store(const Directory& directory);

/// Locks the store against all others, readers too, while the returned files are open, and changes
/// nothing in the store. If the store has no lock file any more, no file is returned.
/// Errors: kBusy (for a writer, the message names its process number); kCorruption, kIo.
std::vector<File> hold_store(const Directory& store);

/// Whether a file of a store can have that name.
bool is_store_file_name(std::string_view name);

/// Removes the files of a store and no others. The manifest goes last. Returns the names of the
/// remaining entries. REQUIRES: hold_store. Errors: kIo.
std::vector<std::string> remove_store_files(const Directory& store);

PLAIT_END_NAMESPACE
