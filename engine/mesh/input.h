// input.h: the bytes of a mesh file, decompressed if need be, through one buffer.
//
// Invariants: 1. Memory is the buffer and the decompressor's own state, whatever the file says.
// 2. offset() counts decompressed bytes. 3. The end of the input is the end of the file, and of
// a compressed file the end of its last frame: one that is cut short is an error.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "plait/file.h"

namespace plait {

class Input {
 public:
  static constexpr std::size_t kBufferBytes = std::size_t{256} << 10;

  /// Opens the file and sees by its first bytes whether it is compressed (gzip or zstd).
  /// Errors: kNotFound, kIo; kInvalidArgument for what is not a regular file.
  explicit Input(const std::filesystem::path& path);
  ~Input();
  Input(const Input&) = delete;
  Input& operator=(const Input&) = delete;

  const std::filesystem::path& path() const { return file_.path(); }
  std::uint64_t offset() const { return buffer_offset_ + begin_; }

  /// Bytes read ahead and not yet consumed; valid until the next fill().
  std::string_view unread() const { return {buffer_.data() + begin_, end_ - begin_}; }
  /// REQUIRES: count <= unread().size().
  void consume(std::size_t count) { begin_ += count; }
  /// Appends to unread(); false at the end of the input.
  /// REQUIRES: unread() is shorter than the buffer.
  bool fill();
  /// Fills until `count` bytes are unread; false if the input ends before.
  /// REQUIRES: count <= kBufferBytes.
  bool ensure(std::size_t count);
  /// Consumes `count` bytes; false if the input ends before.
  bool skip(std::uint64_t count);

  /// At most this many elements of at least `element_bytes` bytes each can be still to come, as
  /// far as the file's size tells: what may be reserved for a promise of `promised`. For
  /// compressed files it is a guess that growing arrays may exceed.
  std::uint64_t plausible_count(std::uint64_t promised, std::uint64_t element_bytes) const;

  /// "read PATH, byte OFFSET: WHAT" as a kInvalidArgument. A byte of a compressed file is one of
  /// its decompressed content.
  [[noreturn]] void refuse_at_byte(std::uint64_t offset, std::string_view what) const;
  [[noreturn]] void refuse_at_line(std::uint64_t line, std::string_view what) const;

 private:
  struct Decompressor;

  std::size_t read_some(char* into, std::size_t capacity);

  File file_;
  std::uint64_t file_bytes_ = 0;
  std::uint64_t file_offset_ = 0;
  std::unique_ptr<Decompressor> decompressor_;  ///< none for a plain file
  std::vector<char> buffer_;
  std::size_t begin_ = 0, end_ = 0;
  std::uint64_t buffer_offset_ = 0;  ///< of the buffer's first byte
};

/// `found` between quotes as a message shows it: shortened, without control characters.
std::string in_quotes(std::string_view found);

}  // namespace plait
