#include "picture/png_file.h"

#include <fmt/format.h>
#include <png.h>

#include <cstddef>
#include <vector>

#include "io/unpublished.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Encodes in memory, because libpng's own functions that write files lose the reason of a failure.
std::vector<std::byte> encode_png(const Image& image, const std::filesystem::path& path) {
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

}  // namespace

void write_png(const Image& image, File& file) { file.write_at(0, encode_png(image, file.path())); }

void write_png(const Image& image, const std::filesystem::path& path) {
  UnpublishedFile output(path, Existing::kReplace);
  write_png(image, output.file());
  output.publish();
}

PLAIT_END_NAMESPACE
