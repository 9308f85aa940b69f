#include "mesh/files/zstd_frames.h"

#include <algorithm>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

std::uint32_t little_endian(const unsigned char* bytes, std::size_t count) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < count; ++i) value |= std::uint32_t{bytes[i]} << (8 * i);
  return value;
}

constexpr std::uint32_t kMagic = 0xfd2fb528u;
constexpr std::uint32_t kSkippableMagic = 0x184d2a50u;  // the first of 16 values

}  // namespace

bool ZstdFrames::starts_with_frame(std::string_view bytes) noexcept {
  if (bytes.size() < 4) return false;
  const std::uint32_t magic =
      little_endian(reinterpret_cast<const unsigned char*>(bytes.data()), 4);
  return magic == kMagic || (magic & ~0xfu) == kSkippableMagic;
}

std::size_t ZstdFrames::part_bytes() const noexcept {
  switch (field_) {
    case FrameField::kMagic:
      return 4;
    case FrameField::kDescriptor:
      return 1;
    case FrameField::kBlockHeader:
      return 3;
    case FrameField::kSkippableSize:
      return 4;
  }
  return 1;
}

void ZstdFrames::follow(std::string_view bytes) noexcept {
  while (!bytes.empty()) {
    if (skip_ > 0) {
      const auto skipped = std::min<std::uint64_t>(skip_, bytes.size());
      bytes.remove_prefix(static_cast<std::size_t>(skipped));
      skip_ -= skipped;
    } else {
      bytes_[filled_++] = static_cast<unsigned char>(bytes.front());
      bytes.remove_prefix(1);
    }
    if (skip_ == 0 && filled_ == part_bytes()) take_part();
  }
}

void ZstdFrames::take_part() noexcept {
  const std::uint32_t value = little_endian(bytes_.data(), filled_);
  filled_ = 0;
  switch (field_) {
    case FrameField::kMagic:
      field_ =
          (value & ~0xfu) == kSkippableMagic ? FrameField::kSkippableSize : FrameField::kDescriptor;
      break;
    case FrameField::kDescriptor: {
      constexpr std::array<std::uint8_t, 4> kDictionaryBytes = {0, 1, 2, 4};
      constexpr std::array<std::uint8_t, 4> kContentSizeBytes = {0, 2, 4, 8};
      const bool single_segment = (value & 0x20u) != 0;
      const std::uint32_t content_size_code = value >> 6;
      checksum_ = (value & 0x04u) != 0;
      skip_ = (single_segment ? 0u : 1u) + kDictionaryBytes[value & 3u];
      skip_ += single_segment && content_size_code == 0 ? 1u : kContentSizeBytes[content_size_code];
      field_ = FrameField::kBlockHeader;
      break;
    }
    case FrameField::kBlockHeader: {
      const bool last = (value & 1u) != 0;
      const bool run_length = (value >> 1 & 3u) == 1;
      skip_ = run_length ? 1u : value >> 3;
      if (last) {
        skip_ += checksum_ ? 4u : 0u;
        field_ = FrameField::kMagic;
        any_frame_ = true;
      }
      break;
    }
    case FrameField::kSkippableSize:
      skip_ = value;
      field_ = FrameField::kMagic;
      any_frame_ = true;
      break;
  }
}

PLAIT_END_NAMESPACE
