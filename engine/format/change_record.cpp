#include "format/change_record.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <utility>

#include "format/byte_order.h"
#include "format/checksum.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr char kRecordMagic[] = "plaitchg";
constexpr std::uint32_t kRecordFormat = 1;
constexpr std::size_t kRecordHeaderBytes = 56, kRecordChecksumBytes = 8;

/// Reads one record. `place` says where it is.
class RecordReader {
 public:
  RecordReader(const File& log, const LogPlace& place, std::uint64_t most_entries)
      : log_(log), place_(place), most_entries_(most_entries) {}

  ChangeRecord read(std::uint64_t version) const {
    std::array<std::byte, kRecordHeaderBytes> header{};
    require(place_.last_record % kLogAlignment == 0 &&
                place_.bytes - place_.last_record >= kRecordHeaderBytes + kRecordChecksumBytes,
            "has no room for a record");
    log_.read_at(place_.last_record, header);
    require(std::memcmp(header.data(), kRecordMagic, 8) == 0 &&
                load<std::uint32_t>(header, 8) == kRecordFormat,
            "expected the header of a record");
    ChangeRecord record;
    record.version = load<std::uint64_t>(header, 16);
    record.before = load<std::uint64_t>(header, 24);
    record.before_checksum = load<std::uint64_t>(header, 32);
    const auto blocks = load<std::uint64_t>(header, 40), pieces = load<std::uint64_t>(header, 48);
    if (record.version != version)
      throw refusal(
          fmt::format("expected the record of version {}, found {}", version, record.version));
    const std::uint64_t room =
        place_.bytes - place_.last_record - kRecordHeaderBytes - kRecordChecksumBytes;
    require(blocks <= most_entries_ && pieces <= most_entries_ - blocks &&
                blocks <= room / sizeof(ChangedBlock) &&
                pieces <= (room - blocks * sizeof(ChangedBlock)) / sizeof(ChangedRecords),
            "the record has more entries than there is room for");
    std::vector<std::byte> bytes(kRecordHeaderBytes + blocks * sizeof(ChangedBlock) +
                                 pieces * sizeof(ChangedRecords) + kRecordChecksumBytes);
    log_.read_at(place_.last_record, bytes);
    const std::uint64_t found =
        checksum_of(std::span(bytes).first(bytes.size() - kRecordChecksumBytes));
    if (found != place_.last_checksum ||
        found != load<std::uint64_t>(bytes, bytes.size() - kRecordChecksumBytes))
      throw refusal(fmt::format("checksum {:016x}, expected {:016x}", found, place_.last_checksum));
    record.blocks.resize(blocks);
    record.records.resize(pieces);
    take(bytes, kRecordHeaderBytes, record.blocks);
    take(bytes, kRecordHeaderBytes + blocks * sizeof(ChangedBlock), record.records);
    // Only bytes before the record are those of this version.
    for (const ChangedBlock& block : record.blocks) check_offset(block.offset, 0);
    for (const ChangedRecords& piece : record.records) check_offset(piece.offset, piece.bytes);
    return record;
  }

 private:
  template <class Entry>
  static void take(std::span<const std::byte> bytes, std::size_t offset,
                   std::vector<Entry>& entries) {
    const std::size_t size = entries.size() * sizeof(Entry);
    if (size > 0) std::memcpy(entries.data(), bytes.subspan(offset, size).data(), size);
  }
  void check_offset(std::uint64_t offset, std::uint64_t bytes) const {
    if (offset % kLogAlignment == 0 && offset <= place_.last_record &&
        bytes <= place_.last_record - offset)
      return;
    throw refusal(
        fmt::format("expected bytes before the record, found {} at byte {}", bytes, offset));
  }
  void require(bool right, const char* reason) const {
    if (!right) throw refusal(reason);
  }
  Error refusal(const std::string& reason) const {
    return Error(ErrorCode::kCorruption,
                 fmt::format("open {}: record at byte {}: {}", log_.path().native(),
                             place_.last_record, reason))
        .about(log_.path(), place_.last_record);
  }

  const File& log_;
  const LogPlace& place_;
  std::uint64_t most_entries_;
};

}  // namespace

std::vector<std::uint64_t> checksums_of_pieces(std::span<const std::byte> records) {
  std::vector<std::uint64_t> checksums;
  for (; !records.empty(); records = records.subspan(std::min(kPieceBytes, records.size())))
    checksums.push_back(checksum_of(records.first(std::min(kPieceBytes, records.size()))));
  return checksums;
}

std::vector<std::byte> encode_change_record(const ChangeRecord& record) {
  const auto blocks = std::as_bytes(std::span(record.blocks)),
             pieces = std::as_bytes(std::span(record.records));
  const std::size_t hashed = kRecordHeaderBytes + blocks.size() + pieces.size();
  std::vector<std::byte> bytes(hashed + kRecordChecksumBytes);
  std::memcpy(bytes.data(), kRecordMagic, 8);
  save(std::span(bytes), 8, kRecordFormat);
  save(std::span(bytes), 16, record.version);
  save(std::span(bytes), 24, record.before);
  save(std::span(bytes), 32, record.before_checksum);
  save(std::span(bytes), 40, std::uint64_t{record.blocks.size()});
  save(std::span(bytes), 48, std::uint64_t{record.records.size()});
  const auto into = std::span(bytes).subspan(kRecordHeaderBytes);
  std::ranges::copy(blocks, into.begin());
  std::ranges::copy(pieces, into.subspan(blocks.size()).begin());
  save(std::span(bytes), hashed, checksum_of(std::span(bytes).first(hashed)));
  return bytes;
}

std::vector<ChangeRecord> read_change_records(const File& log, const Manifest& manifest,
                                              std::uint64_t most_entries) {
  const std::uint64_t size = log.size();
  if (size < manifest.log.bytes)
    throw Error(ErrorCode::kCorruption, fmt::format("open {}: {} bytes, expected at least {}",
                                                    log.path().native(), size, manifest.log.bytes))
        .about(log.path());
  std::vector<ChangeRecord> records;
  LogPlace place = manifest.log;
  for (std::uint64_t version = manifest.sequence; version > manifest.described; --version) {
    records.push_back(RecordReader(log, place, most_entries).read(version));
    const ChangeRecord& record = records.back();
    // The first record has none before it, and each other one comes after the one before.
    const bool is_first = version == manifest.described + 1;
    if (is_first ? record.before != 0 : record.before == 0 || record.before >= place.last_record)
      throw Error(ErrorCode::kCorruption,
                  fmt::format("open {}: record at byte {}: the record before it is at byte {}",
                              log.path().native(), place.last_record, record.before))
          .about(log.path(), place.last_record);
    place.bytes = place.last_record;
    place.last_record = record.before;
    place.last_checksum = record.before_checksum;
  }
  std::ranges::reverse(records);
  return records;
}

PLAIT_END_NAMESPACE
