// The block tables of levels in shards: one file for each shard, which is read when the first block
// of the shard is asked for. So a store of a thousand shards opens as fast as one of a few. Byte
// table: docs/format.md, "Shards".
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "format/manifest.h"
#include "format/version_description.h"
#include "plait/extend/block_table.h"
#include "plait/extend/directory.h"
#include "plait/extend/level_geometry.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct StoredLevel;

inline constexpr std::size_t kShardTablesHeaderBytes = 32;

/// The bytes of the file: the tables of one shard, with attributes in the description's order and
/// levels ascending.
std::vector<std::byte> encode_shard_tables(const StoreUuid& store, std::uint32_t shard,
                                           std::span<const BlockTable> tables);

/// Reads the file `name`, and returns the entries of each level. `levels` are the geometries of the
/// shard alone. Errors: kNotFound; kCorruption for another checksum, header or size, and for an
/// entry out of its range; kIo.
std::vector<std::vector<BlockEntry>> read_shard_tables(const Directory& store,
                                                       const std::string& name,
                                                       const StoreUuid& uuid, std::uint32_t shard,
                                                       std::uint64_t checksum,
                                                       std::span<const LevelGeometry> levels);

/// Gives the levels tables whose entries are read later. `store` must outlive these tables.
void read_shard_tables_later(const Directory& store, const Manifest& manifest,
                             const VersionDescription& description, std::span<StoredLevel> levels);

PLAIT_END_NAMESPACE
