// The manifest names the newest version of a store, and has the size and the checksum of the file
// that describes it, and the place of the changes since. Byte table: docs/format.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "plait/extend/block_table.h"
#include "plait/extend/directory.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Where the records of small commits are (format/change_record.h).
struct LogPlace {
  std::uint64_t generation = 0;     ///< the version that made the log's file; 0: there is no log
  std::uint64_t bytes = 0;          ///< of the file, that the version needs
  std::uint64_t last_record = 0;    ///< offset of the last record; 0 if there is none
  std::uint64_t last_checksum = 0;  ///< of that record

  friend bool operator==(const LogPlace&, const LogPlace&) = default;
};

struct Manifest {
  StoreUuid uuid{};
  std::uint64_t sequence = 0;
  std::uint64_t version_bytes = 0, version_checksum = 0;  ///< of the file version.T
  /// T, the version that the file describes. The log has a record of each version from T + 1 to the
  /// sequence number, which changes some blocks.
  std::uint64_t described = 0;
  LogPlace log = {};
  std::uint32_t required_features = 0;  ///< bits of RequiredFeature
  /// Of the features below; a reader ignores others.
  std::uint32_t optional_features = 0;

  friend bool operator==(const Manifest&, const Manifest&) = default;
};

/// Stored: never renumber.
enum RequiredFeature : std::uint32_t {
  kPredictedBlocks = 1,  ///< a block table has a predicted block
  kShards = 2,           ///< the levels are in shards, which the description lists at its end
  kDepths = 4,           ///< faces have depths of their own, in the file "depths"
  kChangeLog = 8,        ///< the version has a change log
  kSharedFiles = 16,     ///< a shard has one file for all levels of an attribute
};

/// Optional features: the description ends with how attributes were rounded, with texts, with
/// attributes of the base faces.
constexpr std::uint32_t kRoundingsFeature = 1, kTextsFeature = 2, kFacesFeature = 4;
constexpr std::uint32_t kKnownOptionalFeatures = kRoundingsFeature | kTextsFeature | kFacesFeature;

constexpr std::size_t kManifestSlotBytes = 4096;
/// At one commit per nanosecond, a store reaches it after 292 years.
constexpr std::uint64_t kMaxSequence = std::uint64_t{1} << 63;
using ManifestSlot = std::array<std::byte, kManifestSlotBytes>;

ManifestSlot encode_manifest(const Manifest& manifest);

/// Whether the magic number and the checksum are valid: then the whole slot was written.
bool is_whole_slot(std::span<const std::byte, kManifestSlotBytes> slot);

/// Checks that each field is in its range. Errors: kNotSupported for an unknown format version or
/// required flag; kCorruption (the message names the field). The messages begin with `path`.
Manifest decode_manifest(std::span<const std::byte, kManifestSlotBytes> slot,
                         const std::filesystem::path& path);

/// Reads the newest whole slot of the file. Errors: kNotFound if there is no file; kCorruption if
/// no slot is whole.
Manifest read_manifest(const Directory& store);
Manifest read_manifest(const File& file);
/// The slots that are whole and valid, at most two.
std::vector<Manifest> read_whole_slots(const File& file);

/// Creates the manifest that a store has until its first commit. The first slot has sequence number
/// 0 and names no version; the second one is all zeros. With `durable`, the file is on the disk
/// when the call returns.
void create_begun_manifest(const Directory& store, bool durable);
/// Resets an existing manifest to its content before the first commit. Errors: kIo.
void begin_manifest_again(const Directory& store);
/// Whether the manifest is that of a store that was never committed. False for a damaged manifest.
/// Errors: kIo; kCorruption if the manifest is not a regular file.
bool is_begun_manifest(const Directory& store);
bool is_begun_slot(std::span<const std::byte, kManifestSlotBytes> slot);
/// Whether the file can be a manifest of a new store that was written only in part, because its
/// creator was killed.
bool is_begun_manifest_in_part(const Directory& store);
/// Whether a slot is whole, of any format version: then the directory is a store.
bool has_whole_slot(const Directory& store);

/// Writes the slot that belongs to the sequence number.
void write_manifest(File& file, const Manifest& manifest);

PLAIT_END_NAMESPACE
