// export/output_stream.h: writes bytes to a file, compressed or not, through Boost.Iostreams.
#pragma once

#include <boost/iostreams/filtering_stream.hpp>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

enum class StreamCompression : std::uint8_t { kNone, kGzip, kZstd };

/// Memory: a few buffers, and the compressor's window. write() and close() throw the errors of the
/// file, although Boost's streams hide some of them.
class OutputStream {
 public:
  /// `file` is empty and outlives this object.
  OutputStream(File& file, StreamCompression compression);
  ~OutputStream();
  OutputStream(const OutputStream&) = delete;
  OutputStream& operator=(const OutputStream&) = delete;

  /// Cheap for a few bytes: they are gathered here, because each call of a stream costs more than a
  /// triangle.
  void write(std::span<const std::byte> bytes) {
    if (bytes.size() > gathered_.size() - gathered_bytes_) return write_through(bytes);
    if (bytes.empty()) return;
    std::memcpy(gathered_.data() + gathered_bytes_, bytes.data(), bytes.size());
    gathered_bytes_ += bytes.size();
  }
  void write(std::string_view text) { write(std::as_bytes(std::span(text))); }
  /// Finishes the compressed stream. The file stays open. Without close() the file is incomplete.
  void close();
  /// The number of bytes in the file so far; after close(), of all bytes.
  std::uint64_t file_bytes() const { return target_->offset; }

 private:
  struct Target {
    explicit Target(File& its_file) : file(its_file) {}
    File& file;
    std::uint64_t offset = 0;
    std::exception_ptr failure;
  };
  class Sink;

  void rethrow_failure() const;
  /// Gives the stream what is gathered, and then these bytes.
  void write_through(std::span<const std::byte> bytes);
  void give(std::span<const std::byte> bytes);

  std::vector<std::byte> gathered_;  ///< [0, gathered_bytes_): the stream does not have it yet
  std::size_t gathered_bytes_ = 0;
  std::unique_ptr<Target> target_;
  boost::iostreams::filtering_ostream stream_;
};

PLAIT_END_NAMESPACE
