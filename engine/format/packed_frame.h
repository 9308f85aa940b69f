// format/packed_frame.h: zstd frames that state the size of their content, in files that are read
// whole (docs/format.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Adds a frame with `content` to `file`, which messages call `name`. Errors: kOutOfMemory,
/// kCancelled.
void append_frame(std::vector<std::byte>& file, std::span<const std::byte> content,
                  std::string_view name);

/// Of more than 64 MiB of content, a frame must have one byte for this number. A grid of whole
/// numbers has one for 6,000.
constexpr std::uint64_t kMostFrameExpansion = 1u << 14;
/// Whether so large a content in so few bytes is refused: it takes memory from whoever reads it.
bool is_bomb(std::uint64_t frame_bytes, std::uint64_t content_bytes);

/// The bytes of the first frame. Returns 0 if the frame cannot have this content.
std::size_t first_frame_bytes(std::span<const std::byte> frames, std::uint64_t content_bytes);

/// Takes the first frame from `frames`, which must have this content. Returns its content, or
/// nullptr and a reason.
std::unique_ptr<std::byte[]> take_frame(std::span<const std::byte>& frames,
                                        std::uint64_t content_bytes, std::string& reason);

PLAIT_END_NAMESPACE
