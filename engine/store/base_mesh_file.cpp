#include "store/base_mesh_file.h"

#include <fmt/format.h>

#include <cstring>
#include <vector>

#include "plait/error.h"
#include "store/byte_order.h"
#include "store/checksum.h"
#include "store/file_names.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr char kMeshMagic[] = "plaitmsh";
constexpr std::size_t kMeshHeaderBytes = 32, kPositionBytes = 24, kFaceBytes = 12;
static_assert(sizeof(Vector3<double>) == kPositionBytes);

}  // namespace

StoredSize write_base_mesh_file(const Directory& store, const BaseMesh& mesh) {
  const auto positions = std::as_bytes(mesh.positions());
  const auto faces = std::as_bytes(mesh.faces());
  std::vector<std::byte> bytes(kMeshHeaderBytes + positions.size() + faces.size());
  std::memcpy(bytes.data(), kMeshMagic, 8);
  save(std::span(bytes), 8, std::uint32_t{1});
  save(std::span(bytes), 16, mesh.vertex_count());
  save(std::span(bytes), 24, mesh.face_count());
  if (!positions.empty()) std::memcpy(&bytes[kMeshHeaderBytes], positions.data(), positions.size());
  if (!faces.empty())
    std::memcpy(&bytes[kMeshHeaderBytes + positions.size()], faces.data(), faces.size());
  File file(store, kBaseMeshName, OpenMode::kCreate);
  file.write_at(0, bytes);
  file.sync();
  file.close();
  return {bytes.size(), checksum_of(bytes)};
}

BaseMesh read_base_mesh_file(const File& file, const StoredSize& expected) {
  const std::filesystem::path& path = file.path();
  const auto refuse = [&](const std::string& reason) {
    return Error(ErrorCode::kCorruption, fmt::format("open {}: {}", path.native(), reason));
  };
  if (file.size() != expected.bytes || expected.bytes < kMeshHeaderBytes)
    throw refuse(fmt::format("{} bytes, expected {}", file.size(), expected.bytes));
  std::vector<std::byte> bytes(expected.bytes);
  file.read_at(0, bytes);
  if (const std::uint64_t found = checksum_of(bytes); found != expected.checksum)
    throw refuse(fmt::format("checksum {:016x}, expected {:016x}", found, expected.checksum));
  const auto vertex_count = load<std::uint64_t>(bytes, 16);
  const auto face_count = load<std::uint64_t>(bytes, 24);
  if (std::memcmp(bytes.data(), kMeshMagic, 8) != 0 || load<std::uint32_t>(bytes, 8) != 1 ||
      vertex_count >= kNoId || face_count >= kNoId ||
      bytes.size() != kMeshHeaderBytes + vertex_count * kPositionBytes + face_count * kFaceBytes)
    throw refuse("the header contradicts the size");
  IndexedMesh mesh;
  mesh.positions.resize(vertex_count);
  mesh.faces.resize(face_count);
  const std::size_t positions_bytes = vertex_count * kPositionBytes;
  if (vertex_count > 0)
    std::memcpy(mesh.positions.data(), &bytes[kMeshHeaderBytes], positions_bytes);
  if (face_count > 0)
    std::memcpy(mesh.faces.data(), &bytes[kMeshHeaderBytes + positions_bytes],
                face_count * kFaceBytes);
  bytes = {};
  std::vector<std::string> warnings;
  try {
    BaseMesh result = BaseMesh::build(std::move(mesh), path.native(), &warnings);
    if (!warnings.empty()) throw refuse(warnings.front());
    return result;
  } catch (const Error& error) {
    throw Error(ErrorCode::kCorruption, error.what());
  }
}

PLAIT_END_NAMESPACE
