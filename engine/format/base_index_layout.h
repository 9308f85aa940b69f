// Where the arrays of the file base.index are. All sizes follow from counts. Byte table:
// docs/format.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "plait/base_mesh.h"
#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The unit that is read and checked.
inline constexpr std::uint64_t kIndexPageBytes = std::uint64_t{64} << 10;
inline constexpr std::size_t kMeshArrayCount = 8;

/// What a base mesh has of everything.
struct BaseCounts {
  std::uint64_t vertices = 0, edges = 0, faces = 0, border_edges = 0;
  friend bool operator==(const BaseCounts&, const BaseCounts&) = default;
};

/// Which of the maps to the input there are.
struct IndexMaps {
  bool vertices = false, faces = false;
};

class BaseIndexLayout {
 public:
  /// REQUIRES: all counts are below kNoId.
  BaseIndexLayout(const BaseCounts& counts, IndexMaps maps);

  struct Place {
    std::uint64_t offset = 0, bytes = 0;  ///< in the file
    std::uint64_t first_page = 0;         ///< number of its first checksum

    std::uint64_t page_count() const { return (bytes + kIndexPageBytes - 1) / kIndexPageBytes; }
  };
  const Place& place(MeshArray array) const { return places_[static_cast<std::size_t>(array)]; }
  std::uint64_t page_count() const { return page_count_; }
  /// Header, checksums of the pages, and the checksum of both.
  std::uint64_t head_bytes() const { return head_bytes_; }
  std::uint64_t file_bytes() const { return file_bytes_; }

 private:
  std::array<Place, kMeshArrayCount> places_;
  std::uint64_t page_count_ = 0, head_bytes_ = 0, file_bytes_ = 0;
};

// The header. Offsets of its fields; numbers without a type are u64.
inline constexpr char kIndexMagic[] = "plaitidx";
inline constexpr std::uint32_t kIndexFormat = 1;
inline constexpr std::size_t kIndexMapsAt = 12;  ///< u32: bit 0 vertices, bit 1 faces
inline constexpr std::size_t kIndexCountsAt = 16;
inline constexpr std::size_t kIndexInputVerticesAt = 48;
inline constexpr std::size_t kIndexBaseMeshAt = 56;  ///< checksum of base.mesh
inline constexpr std::size_t kIndexHeaderBytes = 64;

PLAIT_END_NAMESPACE
