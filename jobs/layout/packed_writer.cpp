#include "layout/packed_writer.h"

#include <fmt/format.h>
#include <sys/mman.h>

#include <algorithm>

#include "format/checksum.h"
#include "format/content_frame.h"
#include "format/file_names.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Content that passes through memory at addresses of its own: what is needed no more takes no
/// memory.
class PassingContent {
 public:
  explicit PassingContent(std::uint64_t bytes) : bytes_(std::max<std::uint64_t>(bytes, 1)) {
    void* const mapped = ::mmap(nullptr, bytes_, PROT_READ | PROT_WRITE,
                                MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (mapped == MAP_FAILED)
      throw Error(ErrorCode::kOutOfMemory,
                  fmt::format("reserve addresses for a base mesh of {} bytes", bytes_));
    data_ = static_cast<std::byte*>(mapped);
  }
  ~PassingContent() { ::munmap(data_, bytes_); }
  PassingContent(const PassingContent&) = delete;
  PassingContent& operator=(const PassingContent&) = delete;

  std::byte* data() const { return data_; }
  /// Gives the memory of the bytes before `end` back.
  void drop_before(std::uint64_t end) {
    constexpr std::uint64_t kGranule = std::uint64_t{1} << 21;
    end -= end % kGranule;
    if (end > dropped_) ::madvise(data_ + dropped_, end - dropped_, MADV_DONTNEED);
    dropped_ = std::max(dropped_, end);
  }

 private:
  std::byte* data_ = nullptr;
  std::uint64_t bytes_, dropped_ = 0;
};

}  // namespace

PackedWriter::PackedWriter(const Directory& in, std::uint64_t vertex_count,
                           std::uint64_t face_count, std::uint64_t input_vertex_count,
                           PositionWords words)
    : in_(&in),
      vertex_count_(vertex_count),
      face_count_(face_count),
      input_vertex_count_(input_vertex_count),
      words_(words),
      mesh_bytes_(packed_mesh_bytes(vertex_count, face_count, words)),
      maps_bytes_(packed_maps_bytes(vertex_count, face_count)),
      content_(temporary_file(in)),
      corners_(content_, 0, 3 * face_count),
      numbers_(content_, 12 * face_count, vertex_count),
      input_vertices_(content_, mesh_bytes_, vertex_count),
      input_faces_(content_, mesh_bytes_ + 4 * vertex_count, face_count) {
  const std::uint64_t first = 12 * face_count + 4 * vertex_count;
  for (std::uint64_t axis = 0; axis < 3; ++axis) {
    const std::uint64_t offset = first + axis * words.bytes() * vertex_count;
    if (words.bytes() == sizeof(std::uint32_t))
      short_coordinates_.emplace_back(content_, offset, vertex_count);
    else
      long_coordinates_.emplace_back(content_, offset, vertex_count);
  }
}

void PackedWriter::put_position(const Vector3<double>& position) {
  for (int axis = 0; axis < 3; ++axis) {
    const std::uint64_t word = word_of_coordinate(words_, position[axis]);
    const auto at = static_cast<std::size_t>(axis);
    if (long_coordinates_.empty())
      short_coordinates_[at].put(static_cast<std::uint32_t>(word));
    else
      long_coordinates_[at].put(word);
  }
}

StoredSize PackedWriter::finish(const std::function<void(std::uint64_t bytes)>& done) {
  for (auto& coordinate : short_coordinates_) coordinate.flush();
  for (auto& coordinate : long_coordinates_) coordinate.flush();
  corners_.flush();
  numbers_.flush();
  input_vertices_.flush();
  input_faces_.flush();
  File file(*in_, kBaseMeshName, OpenMode::kCreate);
  std::vector<std::byte> bytes =
      base_mesh_header(vertex_count_, face_count_, input_vertex_count_, words_);
  std::uint64_t written = 0;
  const auto add_frame = [&](std::uint64_t first, std::uint64_t count) {
    PassingContent content(count);
    ContentFrame frame(content.data(), count, kBaseMeshName);
    while (!frame.is_done()) {
      const std::uint64_t at = frame.done(), step = std::min(ContentFrame::kStepBytes, count - at);
      content_.read_at(first + at, {content.data() + at, static_cast<std::size_t>(step)});
      frame.add(bytes);
      if (frame.done() > ContentFrame::kLookBackBytes)
        content.drop_before(frame.done() - ContentFrame::kLookBackBytes);
      file.write_at(written, bytes);
      written += bytes.size();
      bytes.clear();
      done(first + frame.done());
    }
  };
  add_frame(0, mesh_bytes_);
  add_frame(mesh_bytes_, maps_bytes_);
  refuse_bomb(in_->path_of(kBaseMeshName), written, vertex_count_, face_count_, words_);
  file.sync();
  const std::uint64_t checksum = checksum_of(file);
  file.close();
  return {written, checksum};
}

PLAIT_END_NAMESPACE
