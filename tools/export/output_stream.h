// export/output_stream.h: writes bytes to a file, compressed or not, through Boost.Iostreams.
#pragma once

#include <boost/iostreams/filtering_stream.hpp>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <span>
#include <string_view>

#include "plait/extend/file.h"

namespace plait {

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

  void write(std::span<const std::byte> bytes);
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

  std::unique_ptr<Target> target_;
  boost::iostreams::filtering_ostream stream_;
};

}  // namespace plait
