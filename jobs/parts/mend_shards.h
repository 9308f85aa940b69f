// Shards of a store that were made again.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "parts/done_file.h"
#include "parts/plan_file.h"
#include "plait/extend/directory.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Puts the files of the parts, which are those of a subdivision, in place of those of the store
/// that the plan has made, if they are younger and have other bytes. Tells `warn` of each part. A
/// part replaces files only if the store records the checksums of its blocks, and `read_blocks`
/// finds them: so the store gets the bytes that it had, whatever passes have changed since. Errors:
/// kBusy, also while readers have the store open; kBadState for a part that is not the one that the
/// store has; kCorruption, kIo, kNoSpace.
void mend_shards(const Directory& plan_directory, const PlanFile& plan,
                 const std::filesystem::path& store, const std::vector<DoneFile>& parts,
                 const std::function<void(const DoneFile&)>& read_blocks,
                 const std::function<void(const std::string&)>& warn);

PLAIT_END_NAMESPACE
