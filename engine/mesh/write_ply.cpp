#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <span>

#include "plait/directory.h"
#include "plait/error.h"
#include "plait/file.h"
#include "plait/mesh_io.h"

namespace plait {
namespace {

/// A file that takes its name only when it is whole, and leaves nothing behind otherwise.
class WholeFile {
 public:
  explicit WholeFile(const std::filesystem::path& path)
      : path_(path), partial_(partial_name(path)), file_(partial_, OpenMode::kCreate) {
    buffer_.reserve(kBufferBytes);
  }
  ~WholeFile() {
    if (published_) return;
    std::error_code ignored;
    std::filesystem::remove(partial_, ignored);
  }
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;

  void write(std::string_view bytes) {
    if (buffer_.size() + bytes.size() > kBufferBytes) flush();
    buffer_.append(bytes);
  }

  void publish() {
    flush();
    file_.sync();
    file_.close();
    if (std::rename(partial_.c_str(), path_.c_str()) != 0)
      throw system_error("write", path_.native(), errno);
    published_ = true;
    Directory(path_.has_parent_path() ? path_.parent_path() : ".").sync();
  }

 private:
  static constexpr std::size_t kBufferBytes = std::size_t{256} << 10;

  /// In the same directory, so that a rename is enough; no two writers share it.
  static std::filesystem::path partial_name(const std::filesystem::path& path) {
    static std::atomic<unsigned> serial{0};
    std::filesystem::path partial = path;
    partial += fmt::format(".partial-{}-{}", ::getpid(), serial++);
    return partial;
  }

  void flush() {
    file_.write_at(offset_, std::as_bytes(std::span(buffer_)));
    offset_ += buffer_.size();
    buffer_.clear();
  }

  std::filesystem::path path_, partial_;
  File file_;
  std::string buffer_;
  std::uint64_t offset_ = 0;
  bool published_ = false;
};

void check_writable(const std::filesystem::path& path, const IndexedMesh& mesh) {
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
  check_writable(path, mesh);
  WholeFile file(path);
  file.write(
      fmt::format("ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\n"
                  "property float y\nproperty float z\nelement face {}\n"
                  "property list uchar int vertex_indices\nend_header\n",
                  mesh.positions.size(), mesh.faces.size()));
  for (const Vector3<double>& p : mesh.positions) {
    const std::array<float, 3> position = {static_cast<float>(p.x), static_cast<float>(p.y),
                                           static_cast<float>(p.z)};
    file.write({reinterpret_cast<const char*>(position.data()), sizeof(position)});
  }
  for (const std::array<VertexId, 3>& face : mesh.faces) {
    std::array<char, 13> record = {3};
    std::memcpy(record.data() + 1, face.data(), sizeof(face));
    file.write({record.data(), record.size()});
  }
  file.publish();
}

}  // namespace plait
