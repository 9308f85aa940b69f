// The manifest: which version of a store is the newest, and the size and checksum of the file
// that describes it. Byte table: docs/format.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "plait/block_table.h"
#include "plait/directory.h"
#include "plait/file.h"

namespace plait {

struct Manifest {
  StoreUuid uuid{};
  std::uint64_t sequence = 0;
  std::uint64_t version_bytes = 0, version_checksum = 0;  ///< of the file version.S

  friend bool operator==(const Manifest&, const Manifest&) = default;
};

constexpr std::size_t kManifestSlotBytes = 4096;
/// One commit a nanosecond takes 292 years.
constexpr std::uint64_t kMaxSequence = std::uint64_t{1} << 63;
using ManifestSlot = std::array<std::byte, kManifestSlotBytes>;

ManifestSlot encode_manifest(const Manifest& manifest);

/// Whether magic and checksum are right: the slot was written whole.
bool is_whole_slot(std::span<const std::byte, kManifestSlotBytes> slot);

/// Every field is checked against its range. Errors: kNotSupported for a version or a required
/// flag that is not known, kCorruption naming the field; both begin with `path`.
Manifest decode_manifest(std::span<const std::byte, kManifestSlotBytes> slot,
                         const std::filesystem::path& path);

/// The newest whole slot of the file. Errors: kNotFound if there is no file, kCorruption if no
/// slot is whole.
Manifest read_manifest(const Directory& store);
Manifest read_manifest(const File& file);
/// Both slots as far as they are whole and right.
std::vector<Manifest> read_whole_slots(const File& file);

/// What a store has until its first commit: a first slot that has sequence number 0 and names
/// nothing, and a second one of zeros. With `durable` it is on the disk when this returns.
void create_begun_manifest(const Directory& store, bool durable);
/// Makes a manifest what it was before the first commit; nothing where there is none. Errors: kIo.
void begin_manifest_again(const Directory& store);
/// Whether a store was begun there and never committed, as far as its manifest says; of one that is
/// damaged this is not known. Errors: kIo; kCorruption if the manifest is no regular file.
bool is_begun_manifest(const Directory& store);
bool is_begun_slot(std::span<const std::byte, kManifestSlotBytes> slot);
/// Whether the file is a manifest of which not all was written before its creator was killed.
bool is_begun_manifest_in_part(const Directory& store);
/// Whether one of the slots is whole, of a known version or not: the directory is a store.
bool has_whole_slot(const Directory& store);

/// Writes the slot that the sequence number says.
void write_manifest(File& file, const Manifest& manifest);

}  // namespace plait
