#include "format/manifest.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <optional>

#include "format/byte_order.h"
#include "format/change_record.h"
#include "format/checksum.h"
#include "format/file_names.h"
#include "plait/error.h"
#include "plait/extend/provenance.h"
#include "plait/version.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::array<unsigned char, 8> kManifestMagic = {0x89, 'p', 'l', 'a', 'i', 't', '\r', '\n'};
constexpr std::uint32_t kManifestVersion = 3;
constexpr std::size_t kSequenceOffset = 40, kDescribedOffset = 64, kChecksumOffset = 4088;

/// A required feature changes the meaning of a store's bytes.
void refuse_unknown_features(std::uint32_t required, const std::filesystem::path& path) {
  constexpr std::uint32_t kKnown = kPredictedBlocks | kShards | kDepths | kChangeLog | kSharedFiles;
  required &= ~kKnown;
  if (required == 0) return;
  throw Error(ErrorCode::kNotSupported,
              fmt::format("open {}: the store needs the feature of required flag {}, and plait {} "
                          "knows only those of flags 0 to 4: predicted blocks, shards, depths, a "
                          "change log and files of several levels",
                          path.native(), std::countr_zero(required), program_version()));
}

/// Returns the whole slots, at most two.
std::vector<ManifestSlot> read_slots(const File& file) {
  const std::uint64_t size = std::min<std::uint64_t>(file.size(), 2 * kManifestSlotBytes);
  std::vector<ManifestSlot> slots;
  for (std::uint64_t at = 0; at + kManifestSlotBytes <= size; at += kManifestSlotBytes) {
    ManifestSlot slot;
    file.read_at(at, slot);
    if (is_whole_slot(slot)) slots.push_back(slot);
  }
  return slots;
}

using BothSlots = std::array<std::byte, 2 * kManifestSlotBytes>;

BothSlots begun_manifest() {
  BothSlots bytes{};
  std::ranges::copy(encode_manifest({}), bytes.begin());
  return bytes;
}

}  // namespace

std::string program_version() { return PLAIT_VERSION; }

ManifestSlot encode_manifest(const Manifest& manifest) {
  ManifestSlot slot{};
  const std::span<std::byte> bytes(slot);
  std::memcpy(bytes.data(), kManifestMagic.data(), kManifestMagic.size());
  save(bytes, 8, kManifestVersion);
  save(bytes, 12, manifest.required_features);
  save(bytes, 16, manifest.optional_features);
  std::ranges::copy(manifest.uuid, bytes.begin() + 24);
  save(bytes, kSequenceOffset, manifest.sequence);
  save(bytes, 48, manifest.version_bytes);
  save(bytes, 56, manifest.version_checksum);
  if (manifest.log.generation != 0) {
    save(bytes, kDescribedOffset, manifest.described);
    save(bytes, kDescribedOffset + 8, manifest.log);
  }
  save(bytes, kChecksumOffset, checksum_of(bytes.first(kChecksumOffset)));
  return slot;
}

bool is_whole_slot(std::span<const std::byte, kManifestSlotBytes> slot) {
  return std::memcmp(slot.data(), kManifestMagic.data(), kManifestMagic.size()) == 0 &&
         load<std::uint64_t>(slot, kChecksumOffset) == checksum_of(slot.first(kChecksumOffset));
}

Manifest decode_manifest(std::span<const std::byte, kManifestSlotBytes> slot,
                         const std::filesystem::path& path) {
  if (const auto version = load<std::uint32_t>(slot, 8); version != kManifestVersion)
    throw Error(ErrorCode::kNotSupported, fmt::format("open {}: format version {}, expected {}",
                                                      path.native(), version, kManifestVersion));
  refuse_unknown_features(load<std::uint32_t>(slot, 12), path);
  const auto require = [&](bool right, std::string_view field, auto found) {
    if (!right)
      throw Error(ErrorCode::kCorruption, fmt::format("open {}: {} is {}, which is out of range",
                                                      path.native(), field, found))
          .about(path);
  };
  Manifest manifest;
  manifest.required_features = load<std::uint32_t>(slot, 12);
  manifest.optional_features = load<std::uint32_t>(slot, 16) & kKnownOptionalFeatures;
  std::ranges::copy(slot.subspan(24, 16), manifest.uuid.begin());
  manifest.sequence = load<std::uint64_t>(slot, kSequenceOffset);
  manifest.version_bytes = load<std::uint64_t>(slot, 48);
  manifest.version_checksum = load<std::uint64_t>(slot, 56);
  require(manifest.sequence > 0 && manifest.sequence <= kMaxSequence, "sequence number",
          manifest.sequence);
  manifest.described = manifest.sequence;
  if ((manifest.required_features & kChangeLog) == 0) return manifest;
  manifest.described = load<std::uint64_t>(slot, kDescribedOffset);
  manifest.log = load<LogPlace>(slot, kDescribedOffset + 8);
  const LogPlace& log = manifest.log;
  require(manifest.described > 0 && manifest.described <= manifest.sequence &&
              manifest.sequence - manifest.described <= kMostChangeRecords,
          "described version", manifest.described);
  require(log.generation > 0 && log.generation <= manifest.described, "change log's version",
          log.generation);
  require(log.bytes <= std::uint64_t{1} << 62, "size of the change log", log.bytes);
  const bool has_records = manifest.described < manifest.sequence;
  require(has_records ? log.last_record > 0 && log.last_record < log.bytes : log.last_record == 0,
          "place of the last record", log.last_record);
  return manifest;
}

Manifest read_manifest(const Directory& store) {
  return read_manifest(File(store, kManifestName, OpenMode::kRead));
}

Manifest read_manifest(const File& file) {
  std::optional<ManifestSlot> newest;
  for (const ManifestSlot& slot : read_slots(file))
    if (!newest ||
        load<std::uint64_t>(slot, kSequenceOffset) > load<std::uint64_t>(*newest, kSequenceOffset))
      newest = slot;
  if (newest && is_begun_slot(*newest))
    throw Error(ErrorCode::kCorruption,
                fmt::format("open {}: expected a version, found a store that was never committed",
                            file.path().native()))
        .about(file.path());
  if (!newest)
    throw Error(ErrorCode::kCorruption,
                fmt::format("open {}: no manifest slot has the right magic and checksum ({} bytes)",
                            file.path().native(), file.size()))
        .about(file.path());
  return decode_manifest(*newest, file.path());
}

std::vector<Manifest> read_whole_slots(const File& file) {
  std::vector<Manifest> versions;
  for (const ManifestSlot& slot : read_slots(file)) {
    try {
      versions.push_back(decode_manifest(slot, file.path()));
    } catch (const Error&) {  // the other slot may be valid
    }
  }
  return versions;
}

void create_begun_manifest(const Directory& store, bool durable) {
  File file(store, kManifestName, OpenMode::kCreate);
  try {
    file.write_at(0, begun_manifest());
    if (durable) file.sync();
    file.close();
    if (durable) store.sync();
  } catch (...) {
    store.remove_if_possible(kManifestName);
    throw;
  }
}

void begin_manifest_again(const Directory& store) {
  if (!store.contains(kManifestName) || is_begun_manifest(store)) return;
  File file(store, kManifestName, OpenMode::kReadWrite);
  file.write_at(0, begun_manifest());
  file.close();
}

bool is_begun_manifest(const Directory& store) {
  const std::optional<File> file = open_if_present(store, kManifestName, OpenMode::kRead);
  BothSlots bytes{};
  if (!file || file->size() != bytes.size()) return false;
  file->read_at(0, bytes);
  return bytes == begun_manifest();
}

bool is_begun_manifest_in_part(const Directory& store) {
  const File file(store, kManifestName, OpenMode::kRead);
  BothSlots bytes{};
  if (file.size() > bytes.size()) return false;
  file.read_at(0, std::span(bytes).first(file.size()));
  const BothSlots whole = begun_manifest();
  for (std::size_t at = 0; at < bytes.size(); ++at)
    if (bytes[at] != std::byte{0} && bytes[at] != whole[at]) return false;
  return true;
}

bool is_begun_slot(std::span<const std::byte, kManifestSlotBytes> slot) {
  return is_whole_slot(slot) && load<std::uint64_t>(slot, kSequenceOffset) == 0;
}

bool has_whole_slot(const Directory& store) {
  const std::optional<File> file = open_if_present(store, kManifestName, OpenMode::kRead);
  return file && !read_slots(*file).empty();
}

void write_manifest(File& file, const Manifest& manifest) {
  file.write_at((manifest.sequence % 2) * kManifestSlotBytes, encode_manifest(manifest));
}

PLAIT_END_NAMESPACE
