#include "format/depths_file.h"

#include <fmt/format.h>

#include <span>

#include "format/checksum.h"
#include "format/file_names.h"
#include "plait/error.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

std::uint64_t write_depths_file(const Directory& store, const FaceDepths& depths, int base_level) {
  std::vector<std::uint8_t> levels(depths.of_faces().begin(), depths.of_faces().end());
  for (std::uint8_t& level : levels) level = static_cast<std::uint8_t>(level + base_level);
  const std::span<const std::byte> bytes = std::as_bytes(std::span(levels));
  store.remove(kDepthsName);
  File file(store, kDepthsName, OpenMode::kCreate);
  file.write_at(0, bytes);
  file.sync();
  file.close();
  return checksum_of(bytes);
}

std::vector<std::uint8_t> read_depths_file(const Directory& store, std::uint64_t face_count,
                                           int base_level, std::uint64_t checksum) {
  const File file(store, kDepthsName, OpenMode::kRead);
  const auto refuse = [&](const std::string& what) {
    throw Error(ErrorCode::kCorruption, fmt::format("open {}: {}", file.path().native(), what))
        .about(file.path());
  };
  if (file.size() != face_count)
    refuse(fmt::format("{} bytes, expected {}", file.size(), face_count));
  std::vector<std::uint8_t> levels(face_count);
  const std::span<std::byte> bytes = std::as_writable_bytes(std::span(levels));
  file.read_at(0, bytes);
  if (const std::uint64_t found = checksum_of(bytes); found != checksum)
    refuse(fmt::format("checksum {:016x}, expected {:016x}", found, checksum));
  for (std::size_t face = 0; face < levels.size(); ++face) {
    if (levels[face] < base_level || levels[face] > kMaxLevel)
      refuse(fmt::format("face {}: level {}, expected {} to {}", face, levels[face], base_level,
                         kMaxLevel));
    levels[face] = static_cast<std::uint8_t>(levels[face] - base_level);
  }
  return levels;
}

std::vector<std::uint32_t> slots_of_levels(const FaceDepths& depths) {
  std::vector<std::uint32_t> slots;
  for (int level = 1; level <= depths.deepest(); ++level)
    slots.push_back(
        static_cast<std::uint32_t>(depths.shapes(BaseRelativeLevel(level)).slot_count()));
  return slots;
}

PLAIT_END_NAMESPACE
