// The manifest: what a version of a store consists of. Byte tables: docs/format.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "plait/attribute.h"
#include "plait/block_table.h"
#include "plait/directory.h"
#include "plait/file.h"

namespace plait {

struct ManifestAttribute {
  AttributeSchema schema;
  std::uint32_t number = 0;
  int finest_level = 0;
  std::uint64_t base_checksum = 0;
};

struct Manifest {
  StoreUuid uuid{};
  std::uint64_t sequence = 0;
  std::uint64_t vertex_count = 0, edge_count = 0, face_count = 0, border_edge_count = 0;
  std::uint64_t block_bytes = 0;
  int base_level = 0;
  std::uint32_t next_attribute_number = 0;
  std::uint64_t base_mesh_bytes = 0, base_mesh_checksum = 0;
  std::uint64_t tables_bytes = 0, tables_checksum = 0;
  std::string backend, codec, filter, layout, scheme;
  std::vector<ManifestAttribute> attributes;
};

constexpr std::size_t kManifestSlotBytes = 4096;
constexpr std::size_t kMaxAttributes = 59;
using ManifestSlot = std::array<std::byte, kManifestSlotBytes>;

/// Errors: kInvalidArgument for a name too long or too many attributes.
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

/// Two slots of zeros, which a store has until its first commit.
void create_blank_manifest(const Directory& store);
/// Whether there is a manifest and no byte of it was ever written.
bool is_blank_manifest(const Directory& store);

/// Writes the slot that the sequence number says.
void write_manifest(File& file, const Manifest& manifest);

/// Whether `name` is 1 to 31 characters of [A-Za-z0-9_-].
bool is_attribute_name(std::string_view name);

}  // namespace plait
