#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>

#include "io/unpublished.h"
#include "plait/error.h"
#include "plait/mesh_io.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Collects bytes in a buffer and writes them to a file many at a time.
class BufferedFile {
 public:
  explicit BufferedFile(File& file) : file_(file) { buffer_.reserve(kBufferBytes); }

  void write(std::string_view bytes) {
    if (buffer_.size() + bytes.size() > kBufferBytes) flush();
    buffer_.append(bytes);
  }
  void flush() {
    file_.write_at(offset_, std::as_bytes(std::span(buffer_)));
    offset_ += buffer_.size();
    buffer_.clear();
  }

 private:
  static constexpr std::size_t kBufferBytes = std::size_t{256} << 10;

  File& file_;
  std::string buffer_;
  std::uint64_t offset_ = 0;
};

void check_numbers_fit(const std::filesystem::path& path, const IndexedMesh& mesh) {
  const auto refuse = [&](const std::string& what) {
    throw Error(ErrorCode::kInvalidArgument, fmt::format("write {}: {}", path.native(), what));
  };
  constexpr auto kMostVertices = std::uint64_t{std::numeric_limits<std::int32_t>::max()};
  if (mesh.positions.size() > kMostVertices)
    refuse(fmt::format("expected at most {} vertices, found {}", kMostVertices,
                       mesh.positions.size()));
  for (std::size_t vertex = 0; vertex < mesh.positions.size(); ++vertex)
    for (int axis = 0; axis < 3; ++axis) {
      const double value = mesh.positions[vertex][axis];
      if (!(std::abs(value) <= std::numeric_limits<float>::max()))
        refuse(
            fmt::format("vertex {}: expected a position within float32, found {}", vertex, value));
    }
  for (std::size_t face = 0; face < mesh.faces.size(); ++face)
    for (const VertexId vertex : mesh.faces[face])
      if (vertex >= mesh.positions.size())
        refuse(fmt::format("face {}: expected vertices below {}, found {}", face,
                           mesh.positions.size(), vertex));
}

}  // namespace

void write_ply(const std::filesystem::path& path, const IndexedMesh& mesh) {
  check_numbers_fit(path, mesh);  // before the file is created
  UnpublishedFile output(path, Existing::kReplace);
  write_ply(output.file(), mesh);
  output.publish();
}

void write_ply(File& file, const IndexedMesh& mesh) {
  check_numbers_fit(file.path(), mesh);
  BufferedFile buffered(file);
  buffered.write(
      fmt::format("ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\n"
                  "property float y\nproperty float z\nelement face {}\n"
                  "property list uchar int vertex_indices\nend_header\n",
                  mesh.positions.size(), mesh.faces.size()));
  for (const Vector3<double>& p : mesh.positions) {
    const std::array<float, 3> position = {static_cast<float>(p.x), static_cast<float>(p.y),
                                           static_cast<float>(p.z)};
    buffered.write({reinterpret_cast<const char*>(position.data()), sizeof(position)});
  }
  for (const std::array<VertexId, 3>& face : mesh.faces) {
    std::array<char, 13> record = {3};
    std::memcpy(record.data() + 1, face.data(), sizeof(face));
    buffered.write({record.data(), record.size()});
  }
  buffered.flush();
}

PLAIT_END_NAMESPACE
