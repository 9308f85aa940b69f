// Makes damaged block tables again from the files of the levels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "plait/extend/check_store.h"
#include "plait/progress.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Reads and seals every block, and returns the file version.S with these block tables. Returns
/// nothing if the result does not have the checksum that the manifest names: then a block is
/// damaged, or was never written. REQUIRES: the store keeps blocks raw and at fixed places; base
/// mesh and description are whole. Errors: kIo; kCancelled.
std::optional<std::vector<std::byte>> tables_from_levels(const std::filesystem::path& path,
                                                         const StoreCheck& check,
                                                         const ProgressCallback& progress = {});

PLAIT_END_NAMESPACE
