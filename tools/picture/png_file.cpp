#include "picture/png_file.h"

#include <fmt/format.h>
#include <png.h>
#include <unistd.h>

#include <cstddef>
#include <span>
#include <system_error>
#include <vector>

#include "plait/error.h"
#include "plait/file.h"

namespace plait {
namespace {

/// Encoded in memory: libpng's own file writing would lose the reason of a failure.
std::vector<std::byte> encode(const Image& image, const std::filesystem::path& path) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width());
  header.height = static_cast<png_uint_32>(image.height());
  header.format = PNG_FORMAT_RGB;
  std::vector<std::byte> bytes(PNG_IMAGE_PNG_SIZE_MAX(header));
  png_alloc_size_t size = bytes.size();
  if (png_image_write_to_memory(&header, bytes.data(), &size, 0, image.pixels().data(), 0,
                                nullptr) == 0)
    throw Error(ErrorCode::kIo, fmt::format("encode {}: {}", path.native(), header.message));
  bytes.resize(size);
  return bytes;
}

/// A file that is gone again unless it gets its real name.
class PartialFile {
 public:
  explicit PartialFile(const std::filesystem::path& path)
      : path_(path), partial_path_(path.native() + fmt::format(".partial-{}", ::getpid())) {
    // One of a process that had our number and was killed.
    std::error_code ignored;
    std::filesystem::remove(partial_path_, ignored);
    file_ = File(partial_path_, OpenMode::kCreate);
  }
  ~PartialFile() {
    std::error_code ignored;
    if (!partial_path_.empty()) std::filesystem::remove(partial_path_, ignored);
  }
  PartialFile(const PartialFile&) = delete;
  PartialFile& operator=(const PartialFile&) = delete;

  void write(std::span<const std::byte> bytes) { file_.write_at(0, bytes); }
  void publish() {
    file_.close();
    std::error_code error;
    std::filesystem::rename(partial_path_, path_, error);
    if (error) throw system_error("rename to", path_.native(), error.value());
    partial_path_.clear();
  }

 private:
  std::filesystem::path path_, partial_path_;
  File file_;
};

}  // namespace

void write_png(const Image& image, const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = encode(image, path);
  PartialFile file(path);
  file.write(bytes);
  file.publish();
}

}  // namespace plait
