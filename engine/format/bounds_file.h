// The optional file attributeA.bounds: for each face, the bounds of the positions of its patch.
// docs/format.md, "attributeA.bounds". No version names the file. Its key says which content of the
// levels it was made of, so bounds of other content are recognised as stale and not used.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "plait/extend/block_table.h"
#include "plait/extend/directory.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The smallest box that contains all vertices of a patch, at all levels. low > high on an axis if
/// no vertex has a number there.
struct FaceBounds {
  std::array<float, 3> low, high;
  friend bool operator==(const FaceBounds&, const FaceBounds&) = default;
};
static_assert(sizeof(FaceBounds) == 24);

/// Two attributes have the same key only if they have the same content. `tables` are those of all
/// levels, coarser ones first, without changes that are not written yet.
std::uint64_t bounds_key(const StoreUuid& store, std::uint32_t attribute,
                         std::uint64_t base_checksum, std::span<const BlockTable* const> tables);

/// The bounds of all faces; nothing if there is no file, or if it has another key. Takes memory
/// only for `face_count` faces. Errors: kCorruption for a file that docs/format.md does not allow;
/// kIo.
std::optional<std::vector<FaceBounds>> read_bounds_file(const Directory& store,
                                                        std::uint32_t attribute,
                                                        std::uint64_t face_count,
                                                        std::uint64_t key);

/// Throws kCorruption as read_bounds_file() does. A missing file and any key are fine. Errors: kIo.
void check_bounds_file(const Directory& store, std::uint32_t attribute, std::uint64_t face_count);

/// Writes the file under another name, then renames it: after a crash there is the old file or the
/// new one. REQUIRES: the caller has the writer's lock. Errors: kIo, kNoSpace.
void write_bounds_file(const Directory& store, std::uint32_t attribute,
                       std::span<const FaceBounds> faces, std::uint64_t key);

PLAIT_END_NAMESPACE
