// zstd_frames.h: tells whether a zstd stream ends where a frame ends. Boost's zstd filter reports
// no error for a stream that was cut short, and returns less data. So this class checks the bytes
// before they go to the filter. It reads only the sizes in the frames; it decodes nothing and
// stores nothing.
//
//   frame: magic(4) descriptor(1) [window(1)] [dictionary(0,1,2,4)] [content size(0,1,2,4,8)]
//          { block header(3) content } until the last block   [checksum(4)]
//   skippable frame: magic 184D2A5x(4) size(4) content
//
// Source: Y. Collet, M. Kucherawy, RFC 8878, section 3.1. Pinned by
// tests/engine/mesh/mesh_io_test.cpp, ReadIndexedMesh_ZstdWithEveryHeaderForm.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

class ZstdFrames {
 public:
  /// Whether the first bytes of a file begin a zstd frame of either kind.
  static bool starts_with_frame(std::string_view bytes) noexcept;

  /// Takes the next bytes of the stream. It does not look for malformed bytes: the decoder does.
  void follow(std::string_view bytes) noexcept;

  /// Whether the bytes so far are one or more whole frames.
  bool at_end() const noexcept {
    return field_ == FrameField::kMagic && filled_ == 0 && skip_ == 0 && any_frame_;
  }

 private:
  enum class FrameField : std::uint8_t { kMagic, kDescriptor, kBlockHeader, kSkippableSize };

  std::size_t part_bytes() const noexcept;
  void take_part() noexcept;

  FrameField field_ = FrameField::kMagic;
  std::array<unsigned char, 4> bytes_{};  ///< the bytes of the current part so far
  std::size_t filled_ = 0;
  std::uint64_t skip_ = 0;  ///< bytes to skip before the current part begins
  bool checksum_ = false;
  bool any_frame_ = false;
};

PLAIT_END_NAMESPACE
