// Replaces one file of a store in one step.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "plait/extend/directory.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Puts the file `from` of another directory, on the same filesystem, in place of the store's file
/// `name`, durably and in one step. Holds the writer's lock meanwhile. `from` was made for version
/// `sequence`. Errors: kBusy, also if there is another version by now; kIo, kNoSpace.
void replace_file(const std::filesystem::path& path, std::uint64_t sequence,
                  const std::string& name, const Directory& from_directory,
                  const std::string& from);

PLAIT_END_NAMESPACE
