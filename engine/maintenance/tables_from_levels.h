// Makes damaged block tables again from the files of the levels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "plait/check_store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The file version.S with block tables made again from the level files of a store that keeps
/// blocks raw and at fixed places: every block is read and sealed. Nothing unless it has the
/// checksum that the manifest names, which it has if every block was written and is whole.
/// REQUIRES: such a store, its base mesh and its description whole. Errors: kIo; kCancelled where
/// `proceed` returns false.
std::optional<std::vector<std::byte>> tables_from_levels(
    const std::filesystem::path& path, const StoreCheck& check,
    const std::function<bool(std::uint64_t done, std::uint64_t total)>& proceed = {});

PLAIT_END_NAMESPACE
