#include "store/base_records.h"

#include <algorithm>
#include <utility>

#include "format/change_record.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Bytes of a file that are in memory at once. Whole pieces (format/change_record.h).
constexpr std::uint64_t kBytesAtOnce = std::uint64_t{256} << 10;
static_assert(kBytesAtOnce % kPieceBytes == 0);

}  // namespace

BaseRecords::BaseRecords(File file, std::uint64_t bytes)
    : file_(std::make_unique<InFile>(std::move(file), bytes)) {
  file_->file.resize(bytes);
}

ZeroedArray<std::byte>& BaseRecords::whole() const {
  if (!file_ || file_->is_loaded.load(std::memory_order_acquire)) return records_;
  const std::lock_guard lock(file_->mutex);
  if (file_->is_loaded.load(std::memory_order_relaxed)) return records_;
  ZeroedArray<std::byte> records(file_->bytes);
  file_->file.read_at(0, records);
  records_ = std::move(records);
  file_->is_loaded.store(true, std::memory_order_release);
  return records_;
}

void BaseRecords::put(std::span<const VertexId> vertices, std::span<const std::byte> records) {
  if (vertices.empty()) return;
  const std::size_t record_bytes = records.size() / vertices.size();
  const std::uint64_t at_once = std::max<std::uint64_t>(1, kBytesAtOnce / record_bytes);
  std::vector<std::byte> bytes;
  for (std::size_t at = 0; at < vertices.size();) {
    std::size_t end = at + 1;
    while (end < vertices.size() && vertices[end] - vertices[at] < at_once) ++end;
    const VertexId first = vertices[at];
    const std::uint64_t count = std::uint64_t{vertices[end - 1]} + 1 - first;
    bytes.resize(count * record_bytes);
    if (count > end - at) read(first * record_bytes, bytes);  // others are among them
    for (std::size_t vertex = at; vertex < end; ++vertex)
      std::ranges::copy(records.subspan(vertex * record_bytes, record_bytes),
                        &bytes[(vertices[vertex] - first) * record_bytes]);
    if (File* const file = this->file())
      file->write_at(first * record_bytes, bytes);
    else
      std::ranges::copy(bytes, records_.data() + first * record_bytes);
    at = end;
  }
}

void BaseRecords::read(std::uint64_t first, std::span<std::byte> into) const {
  if (const File* const file = this->file()) return file->read_at(first, into);
  std::ranges::copy(std::span<const std::byte>(records_).subspan(first, into.size()), into.data());
}

std::vector<std::uint64_t> BaseRecords::piece_checksums() const {
  if (file() == nullptr) return checksums_of_pieces(records_);
  std::vector<std::uint64_t> checksums;
  std::vector<std::byte> bytes;
  for (std::uint64_t first = 0; first < size(); first += kBytesAtOnce) {
    bytes.resize(std::min(kBytesAtOnce, size() - first));
    read(first, bytes);
    const std::vector<std::uint64_t> some = checksums_of_pieces(bytes);
    checksums.insert(checksums.end(), some.begin(), some.end());
  }
  return checksums;
}

PLAIT_END_NAMESPACE
