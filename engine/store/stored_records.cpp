// The records of base vertices and base faces of a StoredVersion.

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <utility>

#include "format/base_records_file.h"
#include "format/change_record.h"
#include "format/checksum.h"
#include "plait/error.h"
#include "store/stored_version.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

template <class Bytes>
Bytes StoredVersion::read_records(const std::string& name, std::uint64_t bytes,
                                  std::uint64_t checksum) const {
  const File file(store_, name, OpenMode::kRead);
  const std::string& path = file.path().native();
  if (file.size() != bytes)
    throw Error(ErrorCode::kCorruption,
                fmt::format("open {}: {} bytes, expected {}", path, file.size(), bytes))
        .about(file.path());
  Bytes records(bytes);
  file.read_at(0, records);
  if (const std::uint64_t found = checksum_of(records); found != checksum)
    throw Error(ErrorCode::kCorruption,
                fmt::format("open {}: checksum {:016x}, expected {:016x}", path, found, checksum))
        .about(file.path());
  return records;
}

void StoredVersion::check_base_file(const AttributeRecord& attribute) const {
  read_records<std::vector<std::byte>>(base_records_name(attribute), attribute.base_bytes,
                                       attribute.base_checksum);
}

ZeroedArray<std::byte> StoredVersion::read_base_records(const AttributeRecord& attribute,
                                                        const BaseMesh& base) const {
  auto records = read_records<ZeroedArray<std::byte>>(
      base_records_name(attribute), attribute.base_bytes, attribute.base_checksum);
  const std::uint64_t bytes = description_.vertex_count * attribute.schema.record_bytes();
  if (records.size() != bytes) {
    ZeroedArray<std::byte> unpacked(bytes);
    const bool follows = follows_base_positions(attribute.schema);
    const auto positions = follows ? base.positions() : std::span<const Vector3<double>>();
    if (const auto reason = decode_base_records(attribute.schema, records, positions, unpacked)) {
      const std::filesystem::path path = store_.path_of(base_records_name(attribute));
      throw Error(ErrorCode::kCorruption, fmt::format("open {}: {}", path.native(), *reason))
          .about(path);
    }
    records = std::move(unpacked);
  }
  for (const ChangeRecord& change : changes())
    for (const ChangedRecords& piece : change.records)
      if (piece.attribute == attribute.number) read_piece(piece, records);
  return records;
}

void StoredVersion::read_piece(const ChangedRecords& piece, std::span<std::byte> records) const {
  const File log(store_, log_name(), OpenMode::kRead);
  const auto refuse = [&](const std::string& reason) {
    return Error(ErrorCode::kCorruption, fmt::format("open {}: base records at byte {}: {}",
                                                     log.path().native(), piece.offset, reason))
        .about(log.path(), piece.offset);
  };
  if (piece.first > records.size() || piece.bytes > records.size() - piece.first)
    throw refuse(fmt::format("expected bytes among the {} of the attribute, found {} from {}",
                             records.size(), piece.bytes, piece.first));
  const std::span<std::byte> into = records.subspan(piece.first, piece.bytes);
  log.read_at(piece.offset, into);
  if (const std::uint64_t found = checksum_of(into); found != piece.checksum)
    throw refuse(fmt::format("checksum {:016x}, expected {:016x}", found, piece.checksum));
}

std::vector<std::byte> StoredVersion::read_face_records(
    const FaceAttributeRecord& attribute) const {
  return read_records<std::vector<std::byte>>(
      face_records_name(attribute), description_.face_count * attribute.schema.record_bytes(),
      attribute.checksum);
}

PLAIT_END_NAMESPACE
