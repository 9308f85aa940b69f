// The file "depths": the finest level of each face, for stores whose faces have depths of their
// own. Byte table: docs/format.md.
#pragma once

#include <cstdint>
#include <vector>

#include "plait/detail/face_depths.h"
#include "plait/extend/directory.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Creates the file and syncs it. Returns its checksum.
std::uint64_t write_depths_file(const Directory& store, const FaceDepths& depths, int base_level);

/// [face] how often it is refined. The size is compared before anything is read. Errors: kNotFound;
/// kCorruption for another size or checksum, and for a level out of its range; kIo.
std::vector<std::uint8_t> read_depths_file(const Directory& store, std::uint64_t face_count,
                                           int base_level, std::uint64_t checksum);

/// [level - 1] the slots that are not absent, as the description has them.
std::vector<std::uint32_t> slots_of_levels(const FaceDepths& depths);

PLAIT_END_NAMESPACE
