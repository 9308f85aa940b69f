#include "mesh/files/input.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/iostreams/filter/gzip.hpp>
#include <boost/iostreams/filter/zstd.hpp>
#include <boost/iostreams/filtering_streambuf.hpp>
#include <cstring>
#include <span>

#include "base/interruption.h"
#include "mesh/files/zstd_frames.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

namespace io = boost::iostreams;

constexpr std::streamsize kFilterBufferBytes = 64 << 10;

bool starts_with_gzip(std::string_view bytes) {
  return bytes.size() >= 2 && bytes[0] == '\x1f' && bytes[1] == '\x8b';
}

std::uint64_t zeros_at_end(const File& file, std::uint64_t file_bytes) {
  std::array<char, 4096> bytes{};
  std::uint64_t zeros = 0;
  while (zeros < file_bytes) {
    const auto count =
        static_cast<std::size_t>(std::min<std::uint64_t>(bytes.size(), file_bytes - zeros));
    file.read_at(file_bytes - zeros - count, std::as_writable_bytes(std::span(bytes).first(count)));
    std::size_t at = count;
    while (at > 0 && bytes[at - 1] == 0) --at;
    zeros += count - at;
    if (at > 0) break;
  }
  return zeros;
}

/// The source from which Boost.Iostreams reads compressed bytes. Boost copies the source, so it
/// contains only pointers.
class CompressedSource {
 public:
  using char_type = char;
  using category = io::source_tag;

  /// `offset` counts what is read.
  CompressedSource(const File& file, std::uint64_t file_bytes, std::uint64_t& offset,
                   ZstdFrames* frames)
      : file_(&file), file_bytes_(file_bytes), frames_(frames), offset_(&offset) {}

  std::streamsize read(char* into, std::streamsize capacity) {
    const auto count = static_cast<std::size_t>(
        std::min(static_cast<std::uint64_t>(capacity), file_bytes_ - *offset_));
    if (count == 0) return -1;
    file_->read_at(*offset_, std::as_writable_bytes(std::span(into, count)));
    *offset_ += count;
    if (frames_ != nullptr) frames_->follow({into, count});
    return static_cast<std::streamsize>(count);
  }

 private:
  const File* file_;
  std::uint64_t file_bytes_;
  ZstdFrames* frames_;
  std::uint64_t* offset_;
};

}  // namespace

struct Input::Decompressor {
  std::uint64_t read_bytes = 0;  ///< of the compressed file
  ZstdFrames frames;
  io::filtering_streambuf<io::input> stream;
};

Input::Input(const std::filesystem::path& path) : file_(path, OpenMode::kRead) {
  file_bytes_ = file_.size();
  std::array<char, 4> magic{};
  const std::size_t magic_bytes =
      static_cast<std::size_t>(std::min<std::uint64_t>(magic.size(), file_bytes_));
  file_.read_at(0, std::as_writable_bytes(std::span(magic).first(magic_bytes)));

  const std::string_view start(magic.data(), magic_bytes);
  is_zstd_ = ZstdFrames::starts_with_frame(start);
  if (is_zstd_ || starts_with_gzip(start)) begin_decompression(file_bytes_);
  buffer_.resize(kBufferBytes);
}

/// As if the file had this number of bytes.
void Input::begin_decompression(std::uint64_t file_bytes) {
  decompressor_ = std::make_unique<Decompressor>();
  auto& stream = decompressor_->stream;
  if (is_zstd_)
    stream.push(io::zstd_decompressor(kFilterBufferBytes), kFilterBufferBytes);
  else
    stream.push(io::gzip_decompressor(io::zlib::default_window_bits, kFilterBufferBytes),
                kFilterBufferBytes);
  stream.push(CompressedSource(file_, file_bytes, decompressor_->read_bytes,
                               is_zstd_ ? &decompressor_->frames : nullptr),
              kFilterBufferBytes);
}

/// Begins again with one zero less as padding, or at first with all zeros of the end, and goes to
/// the place that read_some() had reached. Boost takes the zeros as the header of a further member,
/// and does not say where they begin; up to nine zeros belong to the last member. Returns false if
/// no more can be left out.
bool Input::leave_out_padding() {
  constexpr std::uint64_t kMostZerosOfMember = 9;
  const std::uint64_t zeros = zeros_at_end(file_, file_bytes_);
  if (padding_ ? *padding_ == 0 || zeros - *padding_ >= kMostZerosOfMember : zeros == 0)
    return false;
  padding_ = padding_ ? *padding_ - 1 : zeros;
  begin_decompression(file_bytes_ - *padding_);
  std::vector<char> passed(kFilterBufferBytes);
  for (std::uint64_t left = buffer_offset_ + end_; left > 0;) try {
      const auto most = static_cast<std::streamsize>(std::min<std::uint64_t>(left, passed.size()));
      const std::streamsize count = decompressor_->stream.sgetn(passed.data(), most);
      if (count <= 0) return false;
      left -= static_cast<std::uint64_t>(count);
    } catch (const io::gzip_error&) {
      return leave_out_padding();
    }
  return true;
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
  for (bool again = true; again;) try {
      again = false;
      count = decompressor_->stream.sgetn(into, static_cast<std::streamsize>(capacity));
    } catch (const io::gzip_error& failure) {
      again = leave_out_padding();
      if (!again) refuse_damaged(failure.what());
    } catch (const std::ios_base::failure& failure) {
      refuse_damaged(failure.what());
    }
  if (count <= 0 && is_zstd_ && !decompressor_->frames.at_end())
    refuse_at_byte(buffer_offset_ + end_, "expected whole zstd data, found it cut short");
  return count > 0 ? static_cast<std::size_t>(count) : 0;
}

void Input::refuse_damaged(std::string_view why) const {
  // Boost does not say how much it had decompressed.
  throw Error(
      ErrorCode::kInvalidArgument,
      fmt::format("read {}: expected whole {} data, found it damaged or cut short in the "
                  "first {} bytes of the file ({})",
                  path().native(), is_zstd_ ? "zstd" : "gzip", decompressor_->read_bytes, why))
      .about(path());
}

std::optional<std::uint64_t> Input::content_bytes() {
  if (!decompressor_) return file_bytes_ - offset();
  if (ensure(kBufferBytes)) return std::nullopt;
  return unread().size();
}

bool Input::fill() {
  poll_interruption();
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

bool Input::pass_padding() {
  constexpr std::string_view kPadding("\0\x1a", 2), kPassed("\0\x1a \t\v\f\r\n", 8);
  for (std::uint64_t passed = 0;;) {
    const std::string_view text = unread();
    if (const std::size_t other = text.find_first_not_of(kPassed);
        other != std::string_view::npos) {
      if (passed == 0) return false;
      refuse_at_byte(offset() + other, fmt::format("expected the end after {} bytes of zeros and "
                                                   "blanks, found more",
                                                   passed + other));
    }
    // The bytes stay as long as the buffer has room: they may be no padding.
    if (text.size() < kBufferBytes && fill()) continue;
    for (const char c : text)
      padding_bytes_ += kPadding.find(c) != std::string_view::npos ? 1u : 0u;
    passed += text.size();
    const bool is_full = text.size() == kBufferBytes;
    consume(text.size());
    if (!is_full) return true;
  }
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
