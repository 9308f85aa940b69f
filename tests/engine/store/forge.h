// tests/engine/store/forge.h: stores changed by somebody who makes all checksums right again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "format/byte_order.h"
#include "format/checksum.h"
#include "format/file_names.h"
#include "format/manifest.h"
#include "format/version_description.h"
#include "plait/extend/file.h"

namespace plait::test {

inline std::vector<std::byte> whole_file(const std::filesystem::path& path) {
  const File file(path, OpenMode::kRead);
  std::vector<std::byte> bytes(file.size());
  file.read_at(0, bytes);
  return bytes;
}

inline void write_whole(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  File file(path, OpenMode::kReadWrite);
  file.resize(bytes.size());
  file.write_at(0, bytes);
}

/// The file that describes the newest version.
inline std::filesystem::path version_file(const std::filesystem::path& store) {
  return store / version_file_name(read_manifest(Directory(store)).described);
}

/// Where the block tables begin in it.
inline std::size_t tables_offset(std::span<const std::byte> version) {
  return 32 + load<std::uint64_t>(version, 16);
}

/// Replaces that file, and enters its size and checksum in the manifest.
inline void forge_version_file(const std::filesystem::path& store,
                               std::span<const std::byte> bytes) {
  Manifest manifest = read_manifest(Directory(store));
  manifest.version_bytes = bytes.size();
  manifest.version_checksum = checksum_of(bytes);
  write_whole(version_file(store), bytes);
  File file(store / kManifestName, OpenMode::kReadWrite);
  write_manifest(file, manifest);
}

/// Likewise, with a description that `change` has changed, and the same block tables.
inline void forge_description(const std::filesystem::path& store,
                              const std::function<void(VersionDescription&)>& change) {
  std::vector<std::byte> bytes = whole_file(version_file(store));
  const std::size_t tables = tables_offset(bytes);
  VersionDescription version =
      decode_description(std::span(bytes).subspan(32, tables - 32), kMaxSequence, "forged");
  change(version);
  const std::vector<std::byte> description = encode_description(version);
  std::vector<std::byte> result(bytes.begin(), bytes.begin() + 32);
  save(std::span(result), 16, std::uint64_t{description.size()});
  save(std::span(result), 24, checksum_of(description));
  result.insert(result.end(), description.begin(), description.end());
  result.insert(result.end(), bytes.begin() + static_cast<std::ptrdiff_t>(tables), bytes.end());
  forge_version_file(store, result);
}

}  // namespace plait::test
