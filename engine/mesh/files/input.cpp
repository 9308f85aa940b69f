#include "mesh/files/input.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/iostreams/filter/gzip.hpp>
#include <boost/iostreams/filter/zstd.hpp>
#include <boost/iostreams/filtering_streambuf.hpp>
#include <cstring>
#include <span>

#include "mesh/files/zstd_frames.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

namespace io = boost::iostreams;

constexpr std::streamsize kFilterBufferBytes = 64 << 10;

bool starts_with_gzip(std::string_view bytes) {
  return bytes.size() >= 2 && bytes[0] == '\x1f' && bytes[1] == '\x8b';
}

/// The source from which Boost.Iostreams reads compressed bytes. Boost copies the source, so it
/// contains only pointers.
class CompressedSource {
 public:
  using char_type = char;
  using category = io::source_tag;

  CompressedSource(const File& file, std::uint64_t file_bytes, ZstdFrames* frames)
      : file_(&file), file_bytes_(file_bytes), frames_(frames) {}

  std::streamsize read(char* into, std::streamsize capacity) {
    const auto count = static_cast<std::size_t>(
        std::min(static_cast<std::uint64_t>(capacity), file_bytes_ - offset_));
    if (count == 0) return -1;
    file_->read_at(offset_, std::as_writable_bytes(std::span(into, count)));
    offset_ += count;
    if (frames_ != nullptr) frames_->follow({into, count});
    return static_cast<std::streamsize>(count);
  }

 private:
  const File* file_;
  std::uint64_t file_bytes_;
  ZstdFrames* frames_;
  std::uint64_t offset_ = 0;
};

}  // namespace

struct Input::Decompressor {
  ZstdFrames frames;
  bool is_zstd = false;
  io::filtering_streambuf<io::input> stream;
};

Input::Input(const std::filesystem::path& path) : file_(path, OpenMode::kRead) {
  file_bytes_ = file_.size();
  std::array<char, 4> magic{};
  const std::size_t magic_bytes =
      static_cast<std::size_t>(std::min<std::uint64_t>(magic.size(), file_bytes_));
  file_.read_at(0, std::as_writable_bytes(std::span(magic).first(magic_bytes)));

  const std::string_view start(magic.data(), magic_bytes);
  const bool is_zstd = ZstdFrames::starts_with_frame(start);
  if (is_zstd || starts_with_gzip(start)) {
    decompressor_ = std::make_unique<Decompressor>();
    decompressor_->is_zstd = is_zstd;
    auto& stream = decompressor_->stream;
    if (is_zstd)
      stream.push(io::zstd_decompressor(kFilterBufferBytes), kFilterBufferBytes);
    else
      stream.push(io::gzip_decompressor(io::zlib::default_window_bits, kFilterBufferBytes),
                  kFilterBufferBytes);
    stream.push(CompressedSource(file_, file_bytes_, is_zstd ? &decompressor_->frames : nullptr),
                kFilterBufferBytes);
  }
  buffer_.resize(kBufferBytes);
}

Input::~Input() = default;

std::size_t Input::read_some(char* into, std::size_t capacity) {
  if (!decompressor_) {
    const auto count =
        static_cast<std::size_t>(std::min<std::uint64_t>(capacity, file_bytes_ - file_offset_));
    if (count > 0) file_.read_at(file_offset_, std::as_writable_bytes(std::span(into, count)));
    file_offset_ += count;
    return count;
  }
  std::streamsize count = 0;
  try {
    count = decompressor_->stream.sgetn(into, static_cast<std::streamsize>(capacity));
  } catch (const std::ios_base::failure& failure) {
    refuse_at_byte(buffer_offset_ + end_,
                   fmt::format("expected whole {} data, found it damaged or cut short ({})",
                               decompressor_->is_zstd ? "zstd" : "gzip", failure.what()));
  }
  if (count <= 0 && decompressor_->is_zstd && !decompressor_->frames.at_end())
    refuse_at_byte(buffer_offset_ + end_, "expected whole zstd data, found it cut short");
  return count > 0 ? static_cast<std::size_t>(count) : 0;
}

bool Input::fill() {
  if (begin_ > 0) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    buffer_offset_ += begin_;
    end_ -= begin_;
    begin_ = 0;
  }
  const std::size_t count = read_some(buffer_.data() + end_, buffer_.size() - end_);
  end_ += count;
  return count > 0;
}

bool Input::ensure(std::size_t count) {
  while (end_ - begin_ < count)
    if (!fill()) return false;
  return true;
}

bool Input::skip(std::uint64_t count) {
  while (count > end_ - begin_) {
    count -= end_ - begin_;
    begin_ = end_;
    if (!fill()) return false;
  }
  begin_ += static_cast<std::size_t>(count);
  return true;
}

std::uint64_t Input::plausible_count(std::uint64_t promised, std::uint64_t element_bytes) const {
  // Mesh files compress to between a half and a tenth of their size. A guess that is too low costs
  // a reallocation; one that is too high costs unused address space.
  const std::uint64_t bytes = decompressor_ ? 4 * file_bytes_ : file_bytes_ - offset();
  return std::min(promised, bytes / std::max<std::uint64_t>(element_bytes, 1));
}

void Input::refuse_at_byte(std::uint64_t offset, std::string_view what) const {
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("read {}, byte {}: {}", path().native(), offset, what))
      .about(path(), offset);
}

void Input::refuse_at_line(std::uint64_t line, std::string_view what) const {
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("read {}, line {}: {}", path().native(), line, what))
      .about(path());
}

std::string in_quotes(std::string_view found) {
  constexpr std::size_t kShown = 32;
  std::string result = "'";
  for (const char c : found.substr(0, kShown)) result += c >= ' ' && c <= '~' ? c : '?';
  return result + (found.size() > kShown ? "...'" : "'");
}

PLAIT_END_NAMESPACE
