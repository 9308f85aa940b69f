// Rebuilds files whose damage keeps a store from being opened: block tables, base records, levels.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "maintenance/remaker.h"
#include "plait/verify.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Of a part of a store in shards: the process that made it can make it again.
inline constexpr char kMakeShardAgain[] =
    "make the shard again with plait part --again, and join the plan again; plait plan --of STORE "
    "makes a plan that is gone";

/// Rebuilds each damaged file of the check if its new content has the checksums that manifest and
/// block tables record, and enters it into the report as rebuilt or lost. Puts it in place of the
/// store's file; with options.dry_run leaves it in `scratch`, which is on the same file system.
/// Errors: those of replace_file(); kCancelled.
void repair_files(const std::filesystem::path& store, const StoreCheck& check,
                  const RepairOptions& options, Remaker& remaker, UnpublishedDirectory& scratch,
                  RepairReport& report);

/// Puts the file `name` of another directory, on the same file system, in place of the store's file
/// of this name, durably and in one step. Holds the writer's lock meanwhile. The file was made for
/// version `sequence`. Errors: kBusy, also if there is another version by now; kIo, kNoSpace.
void replace_file(const std::filesystem::path& path, std::uint64_t sequence,
                  const std::string& name, const Directory& from);

PLAIT_END_NAMESPACE
