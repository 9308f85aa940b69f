#include "layout/index_writer.h"

#include <algorithm>

#include "format/base_index_file.h"
#include "format/checksum.h"
#include "format/file_names.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

IndexWriter::IndexWriter(const Directory& in, const BaseCounts& counts, IndexMaps maps,
                         std::uint64_t input_vertex_count)
    : counts_(counts),
      maps_(maps),
      input_vertex_count_(input_vertex_count),
      layout_(counts, maps),
      file_(in, kBaseIndexName, OpenMode::kCreate),
      checksums_(layout_.page_count()) {
  file_.resize(layout_.file_bytes());  // what no array covers is zeros
}

void IndexWriter::put_bytes(MeshArray array, std::span<const std::byte> bytes) {
  std::vector<std::byte>& page = pages_[static_cast<std::size_t>(array)].bytes;
  while (!bytes.empty()) {
    const std::size_t fits = std::min<std::size_t>(bytes.size(), kIndexPageBytes - page.size());
    page.insert(page.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(fits));
    bytes = bytes.subspan(fits);
    if (page.size() == kIndexPageBytes) write_page(array);
  }
}

void IndexWriter::write_page(MeshArray array) {
  Page& page = pages_[static_cast<std::size_t>(array)];
  if (page.bytes.empty()) return;
  const BaseIndexLayout::Place& place = layout_.place(array);
  checksums_[place.first_page + page.number] = checksum_of(page.bytes);
  file_.write_at(place.offset + page.number * kIndexPageBytes, page.bytes);
  ++page.number;
  page.bytes.clear();
}

void IndexWriter::finish(std::uint64_t base_mesh_checksum) {
  for (std::size_t array = 0; array < kMeshArrayCount; ++array)
    write_page(static_cast<MeshArray>(array));
  file_.write_at(
      0, base_index_head(counts_, maps_, input_vertex_count_, base_mesh_checksum, checksums_));
  file_.sync();
  file_.close();
}

PLAIT_END_NAMESPACE
