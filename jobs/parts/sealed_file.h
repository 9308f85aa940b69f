// The form of the files of a plan: which kind of file it is, the number of the format, fields, and
// a checksum at the end, so that a file that is cut is recognised.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "format/checksum.h"
#include "format/field_stream.h"
#include "plait/extend/block_table.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

inline constexpr std::size_t kMostText = 65536;  ///< bytes of a text in such a file

/// Reads the file and checks its checksum and its head.
class SealedFile {
 public:
  /// The file is of one of these kinds, and must outlive this object. Errors: kCorruption, kIo.
  SealedFile(const File& file, std::initializer_list<std::string_view> kinds,
             std::uint64_t most_bytes);
  const std::string& kind() const { return kind_; }
  FieldReader& fields() { return *fields_; }
  std::uint64_t checksum() const { return checksum_; }

 private:
  std::vector<std::byte> bytes_;
  std::uint64_t checksum_ = 0;
  std::string kind_;
  std::optional<FieldReader> fields_;
};

/// The fields of a new file after its head.
FieldWriter begin_sealed(std::string_view kind);
/// The bytes of the file, with the checksum.
std::vector<std::byte> seal(FieldWriter& fields);

void put_uuid(FieldWriter& fields, const StoreUuid& uuid);
StoreUuid take_uuid(FieldReader& fields);

/// Errors: kCorruption for a file of more than 256 MiB of which less than 1/64 is on the disk, as
/// for a store.
void refuse_hole(const File& file);

PLAIT_END_NAMESPACE
