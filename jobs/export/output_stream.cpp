#include "export/output_stream.h"

#include <fmt/format.h>

#include <boost/iostreams/concepts.hpp>
#include <boost/iostreams/filter/zlib.hpp>
#include <boost/iostreams/filter/zstd.hpp>
#include <utility>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr int kBufferBytes = 256 << 10;
constexpr std::size_t kGatheredBytes = 32 << 10;  // stays in the cache of a core
constexpr int kGzipWindowBits = 15 + 16;          // zlib's largest window, and 16 for a gzip frame

}  // namespace

/// Boost.Iostreams copies its devices, so this is only a pointer to the target. Streams do not pass
/// on every exception, so the sink also stores the first one.
class OutputStream::Sink : public boost::iostreams::sink {
 public:
  explicit Sink(Target* target) : target_(target) {}
  std::streamsize write(const char* bytes, std::streamsize count) {
    try {
      const std::span<const char> span(bytes, static_cast<std::size_t>(count));
      target_->file.write_at(target_->offset, std::as_bytes(span));
      target_->offset += span.size();
    } catch (...) {
      if (!target_->failure) target_->failure = std::current_exception();
      throw;
    }
    return count;
  }

 private:
  Target* target_;
};

OutputStream::OutputStream(File& file, StreamCompression compression)
    : gathered_(kGatheredBytes), target_(std::make_unique<Target>(file)) {
  if (compression == StreamCompression::kGzip) {
    boost::iostreams::zlib_params parameters;
    parameters.window_bits = kGzipWindowBits;
    stream_.push(boost::iostreams::zlib_compressor(parameters, kBufferBytes), kBufferBytes);
  }
  if (compression == StreamCompression::kZstd)
    stream_.push(boost::iostreams::zstd_compressor(
                     boost::iostreams::zstd_params(boost::iostreams::zstd::default_compression),
                     kBufferBytes),
                 kBufferBytes);
  stream_.push(Sink(target_.get()), kBufferBytes);
}

OutputStream::~OutputStream() {
  // Without close() the file is incomplete and its owner discards it, so errors do not matter here.
  try {
    if (!stream_.empty()) stream_.reset();
  } catch (...) {
  }
}

void OutputStream::rethrow_failure() const {
  if (target_->failure) std::rethrow_exception(target_->failure);
}

void OutputStream::write_through(std::span<const std::byte> bytes) {
  give(std::span(gathered_).first(std::exchange(gathered_bytes_, 0)));
  give(bytes);
}

void OutputStream::give(std::span<const std::byte> bytes) {
  stream_.write(reinterpret_cast<const char*>(bytes.data()),
                static_cast<std::streamsize>(bytes.size()));
  if (stream_.good()) return;
  rethrow_failure();
  throw Error(ErrorCode::kIo,
              fmt::format("write {}: the compressor failed", target_->file.path().native()));
}

void OutputStream::close() {
  write_through({});
  try {
    stream_.reset();
  } catch (...) {
    rethrow_failure();
    throw;
  }
  rethrow_failure();
}

PLAIT_END_NAMESPACE
