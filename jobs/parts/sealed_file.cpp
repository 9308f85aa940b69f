#include "parts/sealed_file.h"

#include <fmt/format.h>

#include <algorithm>

#include "io/machine.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::uint32_t kFormat = 1;
constexpr std::size_t kChecksumBytes = 8;

std::vector<std::byte> read(const File& file, std::uint64_t most_bytes) {
  const std::uint64_t size = file.size();
  if (size < kChecksumBytes || size > most_bytes)
    throw Error(ErrorCode::kCorruption,
                fmt::format("open {}: expected {} to {} bytes, found {}", file.path().native(),
                            kChecksumBytes, most_bytes, size))
        .about(file.path());
  std::vector<std::byte> bytes(size);
  file.read_at(0, bytes);
  return bytes;
}

}  // namespace

SealedFile::SealedFile(const File& file, std::initializer_list<std::string_view> kinds,
                       std::uint64_t most_bytes)
    : bytes_(read(file, most_bytes)) {
  const std::span<const std::byte> content =
      std::span<const std::byte>(bytes_).first(bytes_.size() - kChecksumBytes);
  checksum_ = load<std::uint64_t>(bytes_, content.size());
  if (const std::uint64_t found = checksum_of(content); found != checksum_)
    throw Error(ErrorCode::kCorruption,
                fmt::format("open {}: expected checksum {:016x}, found {:016x}",
                            file.path().native(), checksum_, found))
        .about(file.path());
  fields_.emplace(content, file.path());
  kind_ = fields_->take_text(kMostText, "the kind of file");
  fields_->require(std::ranges::find(kinds, kind_) != kinds.end(), "the kind of file", kind_);
  const auto format = fields_->take<std::uint32_t>("the format");
  fields_->require(format == kFormat, "the format", format);
}

FieldWriter begin_sealed(std::string_view kind) {
  FieldWriter fields;
  fields.put_text(kind, kMostText, "the kind of file");
  fields.put(kFormat);
  return fields;
}

std::vector<std::byte> seal(FieldWriter& fields) {
  std::vector<std::byte> bytes = fields.take();
  const std::uint64_t checksum = checksum_of(bytes);
  bytes.resize(bytes.size() + kChecksumBytes);
  save(std::span(bytes), bytes.size() - kChecksumBytes, checksum);
  return bytes;
}

void put_uuid(FieldWriter& fields, const StoreUuid& uuid) {
  for (const std::byte byte : uuid) fields.put(static_cast<std::uint8_t>(byte));
}
StoreUuid take_uuid(FieldReader& fields) {
  StoreUuid uuid;
  for (std::byte& byte : uuid) byte = static_cast<std::byte>(fields.take<std::uint8_t>("the UUID"));
  return uuid;
}

void refuse_hole(const File& file) {
  constexpr std::uint64_t kFreelyReadBytes = 256u << 20, kMostBytesForOneOnDisk = 64;
  const std::uint64_t size = file.size(), needed = size / kMostBytesForOneOnDisk;
  if (size > kFreelyReadBytes && bytes_on_disk(file, needed) < needed)
    throw Error(ErrorCode::kCorruption,
                fmt::format("open {}: of its {} bytes less than {} are on the disk, the rest is a "
                            "hole",
                            file.path().native(), size, needed))
        .about(file.path());
}

PLAIT_END_NAMESPACE
