#include "store/manifest.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <optional>
#include <set>

#include "plait/edge_index.h"
#include "plait/error.h"
#include "store/byte_order.h"
#include "store/checksum.h"
#include "store/file_names.h"

namespace plait {
namespace {

constexpr std::array<unsigned char, 8> kMagic = {0x89, 'p', 'l', 'a', 'i', 't', '\r', '\n'};
constexpr std::uint32_t kVersion = 1;
constexpr std::uint32_t kKnownRequiredFlags = 0;
constexpr std::size_t kEntriesOffset = 256, kEntryBytes = 64, kChecksumOffset = 4088;
constexpr std::size_t kTextBytes = 16, kNameBytes = 32;

/// Those of the two slots that are whole.
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

}  // namespace

bool is_attribute_name(std::string_view name) {
  return !name.empty() && name.size() < kNameBytes && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-';
  });
}

ManifestSlot encode_manifest(const Manifest& manifest) {
  if (manifest.attributes.size() > kMaxAttributes)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("write manifest: {} attributes, at most {} fit",
                            manifest.attributes.size(), kMaxAttributes));
  ManifestSlot slot{};
  const std::span<std::byte> bytes(slot);
  std::memcpy(bytes.data(), kMagic.data(), kMagic.size());
  save(bytes, 8, kVersion);
  save(bytes, 20, static_cast<std::uint32_t>(manifest.attributes.size()));
  std::ranges::copy(manifest.uuid, bytes.begin() + 24);
  save(bytes, 40, manifest.sequence);
  save(bytes, 48, manifest.vertex_count);
  save(bytes, 56, manifest.edge_count);
  save(bytes, 64, manifest.face_count);
  save(bytes, 72, manifest.border_edge_count);
  save(bytes, 80, manifest.block_bytes);
  save(bytes, 88, static_cast<std::uint32_t>(manifest.base_level));
  save(bytes, 92, manifest.next_attribute_number);
  save(bytes, 96, manifest.base_mesh_bytes);
  save(bytes, 104, manifest.base_mesh_checksum);
  save(bytes, 112, manifest.tables_bytes);
  save(bytes, 120, manifest.tables_checksum);
  std::size_t offset = 128;
  for (const std::string* text :
       {&manifest.backend, &manifest.codec, &manifest.filter, &manifest.layout, &manifest.scheme}) {
    if (!save_text(bytes, offset, kTextBytes, *text))
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("write manifest: the name '{}' is longer than {} characters", *text,
                              kTextBytes - 1));
    offset += kTextBytes;
  }
  for (std::size_t i = 0; i < manifest.attributes.size(); ++i) {
    const ManifestAttribute& attribute = manifest.attributes[i];
    const std::span<std::byte> entry = bytes.subspan(kEntriesOffset + i * kEntryBytes, kEntryBytes);
    if (!is_attribute_name(attribute.schema.name))
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("write manifest: '{}' is no attribute name", attribute.schema.name));
    save_text(entry, 0, kNameBytes, attribute.schema.name);
    save(entry, 32, attribute.number);
    save(entry, 36, static_cast<std::uint32_t>(attribute.finest_level));
    save(entry, 40, static_cast<std::uint8_t>(attribute.schema.type));
    save(entry, 41, static_cast<std::uint8_t>(attribute.schema.components));
    save(entry, 48, attribute.base_checksum);
  }
  save(bytes, kChecksumOffset, checksum_of(bytes.first(kChecksumOffset)));
  return slot;
}

bool is_whole_slot(std::span<const std::byte, kManifestSlotBytes> slot) {
  return std::memcmp(slot.data(), kMagic.data(), kMagic.size()) == 0 &&
         load<std::uint64_t>(slot, kChecksumOffset) == checksum_of(slot.first(kChecksumOffset));
}

Manifest decode_manifest(std::span<const std::byte, kManifestSlotBytes> slot,
                         const std::filesystem::path& path) {
  if (const auto version = load<std::uint32_t>(slot, 8); version != kVersion)
    throw Error(ErrorCode::kNotSupported, fmt::format("open {}: format version {}, expected {}",
                                                      path.native(), version, kVersion));
  if (const auto flags = load<std::uint32_t>(slot, 12); (flags & ~kKnownRequiredFlags) != 0)
    throw Error(ErrorCode::kNotSupported,
                fmt::format("open {}: required feature flags {:#x}, of which {:#x} are not known",
                            path.native(), flags, flags & ~kKnownRequiredFlags));
  const auto require = [&](bool right, std::string_view field, auto found) {
    if (!right)
      throw Error(ErrorCode::kCorruption, fmt::format("open {}: {} is {}, which is out of range",
                                                      path.native(), field, found));
  };
  Manifest manifest;
  std::ranges::copy(slot.subspan(24, 16), manifest.uuid.begin());
  manifest.sequence = load<std::uint64_t>(slot, 40);
  manifest.vertex_count = load<std::uint64_t>(slot, 48);
  manifest.edge_count = load<std::uint64_t>(slot, 56);
  manifest.face_count = load<std::uint64_t>(slot, 64);
  manifest.border_edge_count = load<std::uint64_t>(slot, 72);
  manifest.block_bytes = load<std::uint64_t>(slot, 80);
  const auto base_level = load<std::uint32_t>(slot, 88);
  manifest.next_attribute_number = load<std::uint32_t>(slot, 92);
  manifest.base_mesh_bytes = load<std::uint64_t>(slot, 96);
  manifest.base_mesh_checksum = load<std::uint64_t>(slot, 104);
  manifest.tables_bytes = load<std::uint64_t>(slot, 112);
  manifest.tables_checksum = load<std::uint64_t>(slot, 120);
  require(manifest.sequence > 0, "sequence number", manifest.sequence);
  require(manifest.vertex_count < kNoId, "vertex count", manifest.vertex_count);
  require(manifest.edge_count < kNoId, "edge count", manifest.edge_count);
  require(manifest.face_count < kNoId, "face count", manifest.face_count);
  require(std::has_single_bit(manifest.block_bytes) && manifest.block_bytes >= 4096 &&
              manifest.block_bytes <= (1u << 30),
          "block size", manifest.block_bytes);
  require(base_level <= kMaxLevel, "base level", base_level);
  manifest.base_level = static_cast<int>(base_level);
  std::size_t offset = 128;
  for (std::string* text :
       {&manifest.backend, &manifest.codec, &manifest.filter, &manifest.layout, &manifest.scheme}) {
    *text = load_text(slot, offset, kTextBytes);
    require(text->size() < kTextBytes, "a name's length", text->size());
    offset += kTextBytes;
  }

  const auto count = load<std::uint32_t>(slot, 20);
  require(count <= kMaxAttributes, "number of attributes", count);
  std::set<std::string> names;
  std::set<std::uint32_t> numbers;
  for (std::size_t i = 0; i < count; ++i) {
    const auto entry = slot.subspan(kEntriesOffset + i * kEntryBytes, kEntryBytes);
    ManifestAttribute attribute;
    attribute.schema.name = load_text(entry, 0, kNameBytes);
    attribute.number = load<std::uint32_t>(entry, 32);
    const auto finest = load<std::uint32_t>(entry, 36);
    attribute.schema.type = static_cast<ComponentType>(load<std::uint8_t>(entry, 40));
    attribute.schema.components = load<std::uint8_t>(entry, 41);
    attribute.base_checksum = load<std::uint64_t>(entry, 48);
    require(is_attribute_name(attribute.schema.name), "an attribute name", i);
    require(names.insert(attribute.schema.name).second, "a repeated attribute name at entry", i);
    require(attribute.number < manifest.next_attribute_number &&
                numbers.insert(attribute.number).second,
            "attribute number", attribute.number);
    require(finest >= base_level && finest <= kMaxLevel, "finest level", finest);
    require(attribute.schema.record_bytes() > 0, "record size", 0);
    attribute.finest_level = static_cast<int>(finest);
    manifest.attributes.push_back(std::move(attribute));
  }
  return manifest;
}

Manifest read_manifest(const Directory& store) {
  return read_manifest(File(store, kManifestName, OpenMode::kRead));
}

Manifest read_manifest(const File& file) {
  std::optional<ManifestSlot> newest;
  for (const ManifestSlot& slot : read_slots(file))
    if (!newest || load<std::uint64_t>(slot, 40) > load<std::uint64_t>(*newest, 40)) newest = slot;
  if (!newest)
    throw Error(ErrorCode::kCorruption,
                fmt::format("open {}: no manifest slot has the right magic and checksum ({} bytes)",
                            file.path().native(), file.size()));
  return decode_manifest(*newest, file.path());
}

std::vector<Manifest> read_whole_slots(const File& file) {
  std::vector<Manifest> versions;
  for (const ManifestSlot& slot : read_slots(file)) {
    try {
      versions.push_back(decode_manifest(slot, file.path()));
    } catch (const Error&) {  // the other one may be right
    }
  }
  return versions;
}

void create_blank_manifest(const Directory& store) {
  File file(store, kManifestName, OpenMode::kCreate);
  file.resize(2 * kManifestSlotBytes);
  file.close();
}

bool is_blank_manifest(const Directory& store) {
  if (!store.contains(kManifestName)) return false;
  const File file(store, kManifestName, OpenMode::kRead);
  std::array<std::byte, 2 * kManifestSlotBytes> bytes{};
  const std::uint64_t size = file.size();
  if (size > bytes.size()) return false;
  file.read_at(0, std::span(bytes).first(size));
  return std::ranges::all_of(bytes, [](std::byte byte) { return byte == std::byte{0}; });
}

void write_manifest(File& file, const Manifest& manifest) {
  file.write_at((manifest.sequence % 2) * kManifestSlotBytes, encode_manifest(manifest));
}

}  // namespace plait
