#include "format/base_mesh_file.h"

#include <fmt/format.h>

#include <array>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "base/text.h"
#include "format/byte_order.h"
#include "format/checksum.h"
#include "format/file_names.h"
#include "format/packed_frame.h"
#include "format/packed_mesh.h"
#include "io/copy_range.h"
#include "io/machine.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr char kMeshMagic[] = "plaitmsh";
constexpr std::size_t kMeshHeaderBytes = 40;
constexpr std::uint32_t kMeshVersion = 3;
/// Of the form of positions, and of the exponent.
constexpr std::size_t kFormOffset = 32, kExponentOffset = 36;
/// For smaller meshes, the memory of the machine is not looked up.
constexpr std::uint64_t kFreelyTakenBytes = 64u << 20;
/// Of the number of the input's vertices; 0 if the file has no maps.
constexpr std::size_t kInputVerticesOffset = 12;

/// Zeros are small in a frame, so a small file can have a mesh that the machine cannot hold.
void refuse_without_memory(const std::filesystem::path& path, std::uint64_t vertex_count,
                           std::uint64_t face_count, PositionWords words) {
  // At least the packed mesh and the unpacked one, at the same time.
  const std::uint64_t needed = packed_mesh_bytes(vertex_count, face_count, words) +
                               vertex_count * sizeof(Vector3<double>) +
                               face_count * sizeof(std::array<VertexId, 3>);
  if (needed <= kFreelyTakenBytes) return;
  if (const std::uint64_t available = available_memory_bytes(); needed > available)
    throw Error(ErrorCode::kOutOfMemory,
                fmt::format("open {}: {} vertices and {} faces need at least {} of memory, and {} "
                            "are available",
                            path.native(), vertex_count, face_count, format_bytes(needed),
                            format_bytes(available)))
        .about(path);
}

/// The bytes that the other file has, if they are those of the checksum.
StoredSize copy_base_mesh_file(const File& from, std::uint64_t checksum, const Directory& store) {
  const StoredSize size{from.size(), checksum_of(from)};
  if (size.checksum != checksum)
    throw Error(ErrorCode::kCorruption, fmt::format("read {}: checksum {:016x}, expected {:016x}",
                                                    from.path().native(), size.checksum, checksum))
        .about(from.path());
  File file(store, kBaseMeshName, OpenMode::kCreate);
  copy_range(from, file, 0, size.bytes);
  file.sync();
  file.close();
  return size;
}

}  // namespace

std::vector<std::byte> base_mesh_header(std::uint64_t vertex_count, std::uint64_t face_count,
                                        std::uint64_t input_vertex_count, PositionWords words) {
  std::vector<std::byte> bytes(kMeshHeaderBytes);
  std::memcpy(bytes.data(), kMeshMagic, 8);
  save(std::span(bytes), 8, kMeshVersion);
  save(std::span(bytes), kInputVerticesOffset, static_cast<std::uint32_t>(input_vertex_count));
  save(std::span(bytes), 16, vertex_count);
  save(std::span(bytes), 24, face_count);
  save(std::span(bytes), kFormOffset, static_cast<std::uint32_t>(words.form));
  save(std::span(bytes), kExponentOffset, static_cast<std::uint32_t>(words.exponent));
  return bytes;
}

void refuse_bomb(const std::filesystem::path& path, std::uint64_t file_bytes,
                 std::uint64_t vertex_count, std::uint64_t face_count, PositionWords words) {
  if (!is_bomb(file_bytes, packed_mesh_bytes(vertex_count, face_count, words))) return;
  throw Error(
      ErrorCode::kNotSupported,
      fmt::format("create {}: expected a base mesh that compresses to 1/{} at most, found "
                  "{} bytes for {} vertices and {} faces: move its vertices apart",
                  path.native(), kMostFrameExpansion, file_bytes, vertex_count, face_count));
}

std::vector<std::byte> base_mesh_file(std::uint64_t vertex_count, std::uint64_t face_count,
                                      PositionWords words, std::span<const std::byte> packed) {
  std::vector<std::byte> bytes = base_mesh_header(vertex_count, face_count, 0, words);
  append_frame(bytes, packed, kBaseMeshName);
  return bytes;
}

void append_input_maps(std::vector<std::byte>& file, std::uint64_t input_vertex_count,
                       std::span<const std::byte> packed) {
  save(std::span(file), kInputVerticesOffset, static_cast<std::uint32_t>(input_vertex_count));
  append_frame(file, packed, kBaseMeshName);
}

StoredSize write_base_mesh_file(const Directory& store, const BaseMesh& mesh) {
  if (const StoredBase stored = mesh.stored_base(); stored.mesh != nullptr)
    return copy_base_mesh_file(*stored.mesh, stored.mesh_checksum, store);
  const PositionWords words = words_of(mesh.positions());
  std::vector<std::byte> bytes =
      base_mesh_file(mesh.vertex_count(), mesh.face_count(), words, pack_mesh(mesh, words));
  if (mesh.differs_from_input()) {
    const InputMaps maps = mesh.input_maps();
    append_input_maps(bytes, maps.input_vertex_count, pack_maps(maps));
  }
  refuse_bomb(store.path_of(kBaseMeshName), bytes.size(), mesh.vertex_count(), mesh.face_count(),
              words);
  File file(store, kBaseMeshName, OpenMode::kCreate);
  file.write_at(0, bytes);
  file.sync();
  file.close();
  return {bytes.size(), checksum_of(bytes)};
}

BaseMesh read_base_mesh_file(const File& file, const StoredSize& expected,
                             std::uint64_t vertex_count, std::uint64_t face_count) {
  const std::filesystem::path& path = file.path();
  const auto refuse = [&](const std::string& reason) {
    return Error(ErrorCode::kCorruption, fmt::format("open {}: {}", path.native(), reason))
        .about(path);
  };
  if (file.size() != expected.bytes || expected.bytes < kMeshHeaderBytes)
    throw refuse(fmt::format("{} bytes, expected {}", file.size(), expected.bytes));
  std::vector<std::byte> bytes(expected.bytes);
  file.read_at(0, bytes);
  if (const std::uint64_t found = checksum_of(bytes); found != expected.checksum)
    throw refuse(fmt::format("checksum {:016x}, expected {:016x}", found, expected.checksum));
  if (std::memcmp(bytes.data(), kMeshMagic, 8) != 0 ||
      load<std::uint32_t>(bytes, 8) != kMeshVersion)
    throw refuse("expected the header of a base mesh");
  if (load<std::uint64_t>(bytes, 16) != vertex_count ||
      load<std::uint64_t>(bytes, 24) != face_count || vertex_count >= kNoId || face_count >= kNoId)
    throw refuse(fmt::format("expected {} vertices and {} faces, found {} and {}", vertex_count,
                             face_count, load<std::uint64_t>(bytes, 16),
                             load<std::uint64_t>(bytes, 24)));
  std::span<const std::byte> frames = std::span<const std::byte>(bytes).subspan(kMeshHeaderBytes);
  const PositionWords words{static_cast<PositionForm>(load<std::uint32_t>(bytes, kFormOffset)),
                            static_cast<std::int32_t>(load<std::uint32_t>(bytes, kExponentOffset))};
  if (!words.valid())
    throw refuse(fmt::format("positions in form {} with exponent {}, which no mesh has",
                             static_cast<std::uint32_t>(words.form), words.exponent));
  const std::uint64_t content_bytes = packed_mesh_bytes(vertex_count, face_count, words);
  const auto input_vertices = load<std::uint32_t>(bytes, kInputVerticesOffset);
  std::string reason;
  if (first_frame_bytes(frames, content_bytes) > 0)
    refuse_without_memory(path, vertex_count, face_count, words);
  auto packed = take_frame(frames, content_bytes, reason);
  if (!packed) throw refuse(reason);
  std::optional<IndexedMesh> mesh =
      unpack_mesh({packed.get(), content_bytes}, vertex_count, face_count, words);
  if (!mesh) throw refuse("a face refers to a vertex that is not there");
  packed.reset();
  std::optional<InputMaps> maps;
  if (input_vertices > 0) {
    packed = take_frame(frames, packed_maps_bytes(vertex_count, face_count), reason);
    if (!packed) throw refuse(reason);
    maps = unpack_maps({packed.get(), packed_maps_bytes(vertex_count, face_count)}, vertex_count,
                       face_count, input_vertices);
    packed.reset();
  }
  if (!frames.empty())
    throw refuse(fmt::format("{} bytes after the last frame, expected none", frames.size()));
  bytes = {};
  std::vector<std::string> warnings;
  try {
    BaseMesh result = BaseMesh::build(*std::move(mesh), path.native(), &warnings);
    if (!warnings.empty()) throw refuse(warnings.front());
    return maps ? std::move(result).with_input_maps(*maps) : std::move(result);
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kCancelled || error.code() == ErrorCode::kOutOfMemory) throw;
    throw Error(ErrorCode::kCorruption, error.what()).about(path);
  }
}

PLAIT_END_NAMESPACE
