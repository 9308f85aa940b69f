// A zstd frame of content that comes step by step. Content in memory and content that is read from
// a file give the same frame, because the compressor gets the same steps.
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

class ContentFrame {
 public:
  /// Of each call of add(); the last step is shorter.
  static constexpr std::uint64_t kStepBytes = 1u << 20;
  /// What the compressor looks back at, at most. Earlier content is not read again.
  static constexpr std::uint64_t kLookBackBytes = 8u << 20;

  /// `content` is the address of the first byte, and those of the others follow. Messages call the
  /// file `name`. Errors: kOutOfMemory.
  ContentFrame(const std::byte* content, std::uint64_t bytes, std::string_view name);
  ~ContentFrame();
  ContentFrame(const ContentFrame&) = delete;
  ContentFrame& operator=(const ContentFrame&) = delete;

  /// Of the content, in bytes.
  std::uint64_t done() const { return done_; }
  bool is_done() const { return is_done_; }
  /// Compresses the next kStepBytes, and appends what is ready of the frame. Errors: kOutOfMemory.
  /// REQUIRES: !is_done(); the bytes are there and do not change until kLookBackBytes later.
  void add(std::vector<std::byte>& frame);

 private:
  struct State;

  std::unique_ptr<State> state_;
  const std::byte* content_;
  std::uint64_t bytes_, done_ = 0;
  bool is_done_ = false;
};

PLAIT_END_NAMESPACE
