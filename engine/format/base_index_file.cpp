#include "format/base_index_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/threads.h"
#include "format/base_index_pages.h"
#include "format/byte_order.h"
#include "format/checksum.h"
#include "format/file_names.h"
#include "io/copy_range.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

// The file has the arrays as they are in memory.
static_assert(sizeof(Vector3<double>) == 24 && sizeof(std::array<VertexId, 3>) == 12 &&
              sizeof(Edge) == 16 && sizeof(FaceSide) == 4 && std::is_trivially_copyable_v<Edge>);

using ArrayBytes = std::array<std::span<const std::byte>, kMeshArrayCount>;

/// All arrays, read and checked, without maps that say nothing.
MeshArrays arrays_to_store(const BaseMesh& mesh) {
  MeshArrays arrays = mesh.all_arrays();
  std::uint32_t next = 0;
  const auto counts_up = [&](std::uint32_t step) {
    return
        [&next, step](std::uint32_t number) { return number == std::exchange(next, next + step); };
  };
  if (arrays.input_vertex_count == arrays.positions.size() &&
      std::ranges::all_of(arrays.input_vertices, counts_up(1)))
    arrays.input_vertices = {};
  next = 0;
  if (std::ranges::all_of(arrays.input_faces, counts_up(2))) arrays.input_faces = {};
  return arrays;
}

ArrayBytes array_bytes(const MeshArrays& arrays) {
  const Topology& mesh = arrays.mesh;
  return {std::as_bytes(arrays.positions),      std::as_bytes(mesh.faces),
          std::as_bytes(mesh.face_edges),       std::as_bytes(mesh.edges),
          std::as_bytes(mesh.vertex_corners),   std::as_bytes(mesh.border_edges),
          std::as_bytes(arrays.input_vertices), std::as_bytes(arrays.input_faces)};
}

BaseCounts counts_of(const MeshArrays& arrays) {
  return {arrays.positions.size(), arrays.mesh.edges.size(), arrays.mesh.faces.size(),
          arrays.mesh.border_edges.size()};
}

IndexMaps maps_of(const MeshArrays& arrays) {
  return {!arrays.input_vertices.empty(), !arrays.input_faces.empty()};
}

BaseIndexLayout layout_of(const MeshArrays& arrays) { return {counts_of(arrays), maps_of(arrays)}; }

std::vector<std::uint64_t> page_checksums(const MeshArrays& all) {
  const BaseIndexLayout layout = layout_of(all);
  const ArrayBytes arrays = array_bytes(all);
  std::vector<std::uint64_t> checksums(layout.page_count());
  for (std::size_t array = 0; array < kMeshArrayCount; ++array) {
    const auto& place = layout.place(static_cast<MeshArray>(array));
    each_on_workers(std::uint64_t{0}, place.page_count(), [&](std::uint64_t page) {
      const std::uint64_t first = page * kIndexPageBytes;
      checksums[place.first_page + page] =
          checksum_of(arrays[array].subspan(first, std::min(kIndexPageBytes, place.bytes - first)));
    });
  }
  return checksums;
}

/// A copy of a whole file.
void copy_file(const File& from, const Directory& in, const std::string& name, bool durable) {
  File file(in, name, OpenMode::kCreate);
  copy_range(from, file, 0, from.size());
  if (durable) file.sync();
  file.close();
}

}  // namespace

std::vector<std::byte> base_index_head(const BaseCounts& counts, IndexMaps maps,
                                       std::uint64_t input_vertex_count,
                                       std::uint64_t base_mesh_checksum,
                                       std::span<const std::uint64_t> checksums) {
  std::vector<std::byte> head(BaseIndexLayout(counts, maps).head_bytes());
  const std::span<std::byte> to(head);
  std::memcpy(head.data(), kIndexMagic, 8);
  save(to, 8, kIndexFormat);
  save(to, kIndexMapsAt, (maps.vertices ? 1u : 0u) | (maps.faces ? 2u : 0u));
  std::size_t at = kIndexCountsAt;
  for (const std::uint64_t count :
       {counts.vertices, counts.edges, counts.faces, counts.border_edges}) {
    save(to, at, count);
    at += 8;
  }
  save(to, kIndexInputVerticesAt, input_vertex_count);
  save(to, kIndexBaseMeshAt, base_mesh_checksum);
  for (std::size_t page = 0; page < checksums.size(); ++page)
    save(to, kIndexHeaderBytes + 8 * page, checksums[page]);
  const std::size_t content = head.size() - 8;
  save(to, content, checksum_of(std::span(head).first(content)));
  return head;
}

void write_base_index_file(const Directory& in, const std::string& name, const BaseMesh& mesh,
                           std::uint64_t base_mesh_checksum, bool durable) {
  if (const StoredBase stored = mesh.stored_base();
      stored.index != nullptr && stored.mesh_checksum == base_mesh_checksum)
    return copy_file(*stored.index, in, name, durable);
  const MeshArrays all = arrays_to_store(mesh);
  const ArrayBytes arrays = array_bytes(all);
  const BaseIndexLayout layout = layout_of(all);
  const std::vector<std::byte> head =
      base_index_head(counts_of(all), maps_of(all), all.input_vertex_count, base_mesh_checksum,
                      page_checksums(all));
  File file(in, name, OpenMode::kCreate);
  file.resize(layout.file_bytes());  // what no array covers is zeros
  file.write_at(0, head);
  for (std::size_t array = 0; array < kMeshArrayCount; ++array)
    if (!arrays[array].empty())
      file.write_at(layout.place(static_cast<MeshArray>(array)).offset, arrays[array]);
  if (durable) file.sync();
  file.close();
}

void add_base_index_file(const Directory& store, const BaseMesh& mesh,
                         std::uint64_t base_mesh_checksum, bool durable) {
  store.remove(kNewBaseIndexName);  // a killed process may have left it
  try {
    write_base_index_file(store, kNewBaseIndexName, mesh, base_mesh_checksum, durable);
    store.rename(kNewBaseIndexName, store, kBaseIndexName);
    if (durable) store.sync();
  } catch (...) {
    store.remove_if_possible(kNewBaseIndexName);
    throw;
  }
}

std::optional<BaseMesh> open_base_index_file(const Directory& store, const ExpectedBase& expected) {
  std::optional<File> file = open_if_present(store, kBaseIndexName, OpenMode::kRead);
  if (!file) return std::nullopt;
  return BaseMesh::of(std::make_shared<const BaseIndexPages>(std::move(*file), expected));
}

void check_base_index_file(const Directory& store, const ExpectedBase& expected,
                           const BaseMesh* mesh) {
  const std::optional<BaseMesh> stored = open_base_index_file(store, expected);
  if (!stored) return;
  const File file(store, kBaseIndexName, OpenMode::kRead);
  const auto refuse = [&](const std::string& what) {
    return Error(ErrorCode::kCorruption, fmt::format("read {}: {}", file.path().native(), what))
        .about(file.path());
  };
  const ArrayBytes found = array_bytes(stored->all_arrays());
  const BaseIndexLayout layout = layout_of(stored->arrays());
  const auto check_zeros = [&](std::uint64_t first, std::uint64_t end) {
    std::vector<std::byte> bytes(end - first);
    file.read_at(first, bytes);
    if (std::ranges::any_of(bytes, [](std::byte byte) { return byte != std::byte{0}; }))
      throw refuse(fmt::format("bytes {} to {}: expected zeros", first, end));
  };
  check_zeros(layout.head_bytes(), layout.place(MeshArray::kPositions).offset);
  for (std::size_t array = 0; array < kMeshArrayCount; ++array) {
    const auto& place = layout.place(static_cast<MeshArray>(array));
    check_zeros(place.offset + place.bytes,
                array + 1 == kMeshArrayCount
                    ? layout.file_bytes()
                    : layout.place(static_cast<MeshArray>(array + 1)).offset);
  }
  if (mesh == nullptr) return;
  const ArrayBytes right = array_bytes(arrays_to_store(*mesh));
  if (stored->arrays().input_vertex_count != mesh->arrays().input_vertex_count)
    throw refuse(fmt::format("expected {} vertices of the input, as base.mesh says, found {}",
                             mesh->arrays().input_vertex_count,
                             stored->arrays().input_vertex_count));
  for (std::size_t array = 0; array < kMeshArrayCount; ++array)
    if (!std::ranges::equal(found[array], right[array]))
      throw refuse(
          fmt::format("array {}: expected what follows from base.mesh, found another", array));
}

PLAIT_END_NAMESPACE
