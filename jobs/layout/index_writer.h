// Writes the file base.index of a mesh that is not in memory: each array front to back, any of them
// at any time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "format/base_index_layout.h"
#include "layout/temporary_file.h"
#include "plait/base_mesh.h"
#include "plait/extend/directory.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

class IndexWriter {
 public:
  /// Creates the file. Errors: kIo, kNoSpace.
  IndexWriter(const Directory& in, const BaseCounts& counts, IndexMaps maps,
              std::uint64_t input_vertex_count);

  template <class Element>
  void put(MeshArray array, const Element& element) {
    put_bytes(array, std::as_bytes(std::span(&element, 1)));
  }
  /// Reads an array that has all its elements.
  template <class Element>
  SequentialReader<Element> read(MeshArray array) {
    const BaseIndexLayout::Place& place = layout_.place(array);
    write_page(array);
    return {file_, place.offset, place.bytes / sizeof(Element), std::size_t{1} << 20};
  }
  /// Syncs and closes the file. REQUIRES: all arrays have all their elements.
  void finish(std::uint64_t base_mesh_checksum);

 private:
  struct Page {
    std::uint64_t number = 0;  ///< of the array
    std::vector<std::byte> bytes;
  };

  void put_bytes(MeshArray array, std::span<const std::byte> bytes);
  void write_page(MeshArray array);

  BaseCounts counts_;
  IndexMaps maps_;
  std::uint64_t input_vertex_count_;
  BaseIndexLayout layout_;
  File file_;
  std::array<Page, kMeshArrayCount> pages_;
  std::vector<std::uint64_t> checksums_;
};

PLAIT_END_NAMESPACE
