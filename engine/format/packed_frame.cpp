#include "format/packed_frame.h"

#include <fmt/format.h>
#include <zstd.h>

#include "base/interruption.h"
#include "format/content_frame.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// A block of a zstd frame takes 4 bytes at least and gives this number at most.
constexpr std::uint64_t kLeastBlockBytes = 4, kMostContentBytes = 1u << 17;
/// Smaller contents may be anything: the memory is not worth a rule.
constexpr std::uint64_t kFreeContentBytes = 64u << 20;

}  // namespace

void append_frame(std::vector<std::byte>& file, std::span<const std::byte> content,
                  std::string_view name) {
  ContentFrame frame(content.data(), content.size(), name);
  while (!frame.is_done()) {
    poll_interruption();
    frame.add(file);
  }
}

bool is_bomb(std::uint64_t frame_bytes, std::uint64_t content_bytes) {
  return content_bytes > kFreeContentBytes && content_bytes / kMostFrameExpansion > frame_bytes;
}

std::size_t first_frame_bytes(std::span<const std::byte> frames, std::uint64_t content_bytes) {
  const std::size_t bytes = ZSTD_findFrameCompressedSize(frames.data(), frames.size());
  if (ZSTD_isError(bytes) ||
      ZSTD_getFrameContentSize(frames.data(), frames.size()) != content_bytes ||
      content_bytes / kMostContentBytes > bytes / kLeastBlockBytes || is_bomb(bytes, content_bytes))
    return 0;
  return bytes;
}

std::unique_ptr<std::byte[]> take_frame(std::span<const std::byte>& frames,
                                        std::uint64_t content_bytes, std::string& reason) {
  const std::size_t frame_bytes = first_frame_bytes(frames, content_bytes);
  if (frame_bytes == 0) {
    reason = fmt::format("expected a zstd frame of {} bytes", content_bytes);
    return nullptr;
  }
  auto content = std::make_unique_for_overwrite<std::byte[]>(content_bytes);
  const std::size_t found =
      ZSTD_decompress(content.get(), content_bytes, frames.data(), frame_bytes);
  frames = frames.subspan(frame_bytes);
  if (found == content_bytes) return content;
  reason = fmt::format("zstd: {}",
                       ZSTD_isError(found) ? ZSTD_getErrorName(found) : "fewer bytes than stated");
  return nullptr;
}

PLAIT_END_NAMESPACE
