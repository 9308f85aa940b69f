// Where a shard of a level is: in the file of all levels of the attribute, or, in older stores and
// with backends that cannot share files, in a file of its own. Bytes: docs/format.md, "Shards".
#pragma once

#include <cstdint>
#include <string>

#include "plait/detail/namespace.h"
#include "plait/extend/backend.h"
#include "plait/extend/level_geometry.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct ShardPlace {
  std::string name;  ///< of the file
  bool shares_file = false;
  std::uint64_t first_byte = 0;

  /// Enters file and place.
  void put_into(LevelSpec& level) const;
};

/// A shard of a level. The geometry is that of the shard alone.
struct ShardOfLevel {
  std::uint32_t attribute = 0;
  int level = 0;
  std::uint64_t generation = 0;
  std::uint32_t shard = 0;
  const LevelGeometry& geometry;
};

/// `shares_files`: as in VersionDescription.
ShardPlace place_of(const ShardOfLevel& level, bool shares_files, const BackendTraits& traits);

/// The bytes that a level of raw blocks takes of a shared file. The geometry is that of the shard
/// alone, and its blocks are at the offsets that it gives (BackendTraits::overwrites_in_place).
std::uint64_t bytes_in_shared_file(const LevelGeometry& geometry);

/// The name of the file alone.
std::string shard_file_name(bool shares_files, std::uint32_t attribute, int level,
                            std::uint64_t generation, std::uint32_t shard);

PLAIT_END_NAMESPACE
