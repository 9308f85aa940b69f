// input.h: reads the bytes of a mesh file through one buffer, and decompresses them if the file is
// compressed.
//
// Invariants: 1. The object uses the memory of the buffer and of the decompressor's state, whatever
// the file contains. 2. offset() counts decompressed bytes. 3. The input ends where the file ends.
// A compressed file must end at the end of a frame; otherwise it was cut short, and that is an
// error. Zeros behind the last member of a gzip file are padding.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "plait/extend/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

class Input {
 public:
  static constexpr std::size_t kBufferBytes = std::size_t{256} << 10;

  /// Opens the file and checks its first bytes for gzip and zstd compression.
  /// Errors: kNotFound, kIo; kInvalidArgument for anything but a regular file.
  explicit Input(const std::filesystem::path& path);
  ~Input();
  Input(const Input&) = delete;
  Input& operator=(const Input&) = delete;

  /// Whether readers take coordinates that are not finite. At first they refuse them.
  void keep_not_finite(bool keep) { keeps_not_finite_ = keep; }
  bool takes(double coordinate) const { return keeps_not_finite_ || std::isfinite(coordinate); }

  const std::filesystem::path& path() const { return file_.path(); }
  std::uint64_t offset() const { return buffer_offset_ + begin_; }

  /// The bytes that are in the buffer and not yet consumed; valid until the next fill().
  std::string_view unread() const { return {buffer_.data() + begin_, end_ - begin_}; }
  /// REQUIRES: count <= unread().size().
  void consume(std::size_t count) { begin_ += count; }
  /// Reads more bytes, which unread() then includes. Returns false at the end of the input.
  /// REQUIRES: unread() is shorter than the buffer.
  bool fill();
  /// Reads until unread() has `count` bytes. Returns false if the input ends before.
  /// REQUIRES: count <= kBufferBytes.
  bool ensure(std::size_t count);
  /// Consumes `count` bytes. Returns false if the input ends before.
  bool skip(std::uint64_t count);

  /// If nothing but zeros, ^Z, blanks and line ends is left, consumes all of it, counts it as
  /// padding and returns true: writers of fixed records and editors of DOS put these behind a text.
  /// Errors: kInvalidArgument if more follows behind a buffer full of them.
  bool pass_padding();
  std::uint64_t padding_bytes() const { return padding_bytes_; }

  /// How many elements to reserve memory for, when a header promises `promised` elements of at
  /// least `element_bytes` bytes each: no more than the rest of the file can contain. For a
  /// compressed file the result is a guess, and arrays may grow beyond it.
  std::uint64_t plausible_count(std::uint64_t promised, std::uint64_t element_bytes) const;

  /// Bytes from here to the end, if that is known: of a compressed file only if the rest fits into
  /// the buffer.
  std::optional<std::uint64_t> content_bytes();

  /// Throws kInvalidArgument with the message "read PATH, byte OFFSET: WHAT". Offsets count bytes
  /// of the decompressed content.
  [[noreturn]] void refuse_at_byte(std::uint64_t offset, std::string_view what) const;
  [[noreturn]] void refuse_at_line(std::uint64_t line, std::string_view what) const;

 private:
  struct Decompressor;

  std::size_t read_some(char* into, std::size_t capacity);
  void begin_decompression(std::uint64_t file_bytes);
  bool leave_out_padding();
  [[noreturn]] void refuse_damaged(std::string_view why) const;

  File file_;
  bool keeps_not_finite_ = false;
  std::uint64_t file_bytes_ = 0;
  std::uint64_t file_offset_ = 0;
  bool is_zstd_ = false;
  std::unique_ptr<Decompressor> decompressor_;  ///< none for a plain file
  /// Zeros at the end of a gzip file that are tried as padding; those before belong to the data.
  std::optional<std::uint64_t> padding_;
  std::uint64_t padding_bytes_ = 0;  ///< zeros and ^Z that pass_padding() consumed
  std::vector<char> buffer_;
  std::size_t begin_ = 0, end_ = 0;
  std::uint64_t buffer_offset_ = 0;  ///< of the buffer's first byte
};

/// `found` in quotes for a message: shortened, without control characters.
std::string in_quotes(std::string_view found);

PLAIT_END_NAMESPACE
