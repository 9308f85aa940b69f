// The manifest: what is written is read again, and nothing else is believed.
#include "format/manifest.h"

#include <catch2/catch.hpp>
#include <cstring>
#include <functional>

#include "engine/store/sample_store.h"
#include "format/byte_order.h"
#include "format/change_record.h"
#include "format/checksum.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"

using namespace plait;
using namespace plait::test;

namespace {

/// Every field differs from every other and from zero.
Manifest full_manifest() {
  Manifest manifest;
  for (std::size_t i = 0; i < manifest.uuid.size(); ++i)
    manifest.uuid[i] = static_cast<std::byte>(200 + i);
  manifest.sequence = manifest.described = 0x0123456789abcdefu;
  manifest.version_bytes = 305;
  manifest.version_checksum = 0xfedcba9876543211u;
  return manifest;
}

/// A manifest file with the versions `sequences`, in the slots that these say.
class ManifestFile {
 public:
  explicit ManifestFile(const std::vector<std::uint64_t>& sequences)
      : file_(path(), OpenMode::kCreate) {
    file_.resize(2 * kManifestSlotBytes);
    for (const std::uint64_t sequence : sequences) {
      Manifest manifest = full_manifest();
      manifest.sequence = manifest.described = sequence;
      write_manifest(file_, manifest);
    }
  }
  std::filesystem::path path() const { return directory_.path() / "manifest"; }
  void flip(std::uint64_t offset, std::byte mask) {
    std::byte value;
    file_.read_at(offset, std::span(&value, 1));
    value ^= mask;
    file_.write_at(offset, std::span(&value, 1));
  }
  void resize(std::uint64_t bytes) { file_.resize(bytes); }

 private:
  TemporaryDirectory directory_;
  File file_;
};

/// A valid slot with `value` at `offset` and the checksum that goes with it.
template <class Value>
ManifestSlot forged(std::size_t offset, Value value) {
  ManifestSlot slot = encode_manifest(full_manifest());
  save(std::span<std::byte>(slot), offset, value);
  save(std::span<std::byte>(slot), 4088, checksum_of(std::span(slot).first(4088)));
  return slot;
}

}  // namespace

TEST_CASE("Manifest_Encoded_IsReadAsWritten") {
  const ManifestSlot slot = encode_manifest(full_manifest());
  CHECK(is_whole_slot(slot));
  CHECK(decode_manifest(slot, "manifest") == full_manifest());
}

TEST_CASE("ReadManifest_OnlySlotWithAFlippedByte_IsRefused") {
  for (const std::uint64_t sequence : {1u, 2u}) {
    ManifestFile file({sequence});
    REQUIRE(read_manifest(File(file.path(), OpenMode::kRead)).sequence == sequence);
    for (std::uint64_t byte = 0; byte < kManifestSlotBytes; ++byte) {
      const std::uint64_t offset = (sequence % 2) * kManifestSlotBytes + byte;
      const auto mask = static_cast<std::byte>(1u << (byte % 8));
      file.flip(offset, mask);
      INFO("byte " << byte);
      const Error error = error_of([&] { read_manifest(File(file.path(), OpenMode::kRead)); });
      REQUIRE(error.code() == ErrorCode::kCorruption);
      file.flip(offset, mask);
    }
  }
}

TEST_CASE("ReadManifest_OneOfTwoSlotsWithAFlippedByte_TakesTheOther") {
  ManifestFile file({1, 2});  // version 2 is in the first slot
  REQUIRE(read_manifest(File(file.path(), OpenMode::kRead)).sequence == 2);
  for (std::uint64_t offset = 0; offset < 2 * kManifestSlotBytes; ++offset) {
    const auto mask = static_cast<std::byte>(1u << (offset % 8));
    file.flip(offset, mask);
    INFO("byte " << offset);
    REQUIRE(read_manifest(File(file.path(), OpenMode::kRead)).sequence ==
            (offset < kManifestSlotBytes ? 1 : 2));
    file.flip(offset, mask);
  }
}

TEST_CASE("ReadManifest_FileCutShort_TakesTheSlotsThatAreWhole") {
  ManifestFile file({1, 2});
  for (const std::uint64_t bytes : {8191u, 4096u}) {
    file.resize(bytes);
    CHECK(read_manifest(File(file.path(), OpenMode::kRead)).sequence == 2);
  }
  for (const std::uint64_t bytes : {4095u, 1u, 0u}) {
    file.resize(bytes);
    const Error error = error_of([&] { read_manifest(File(file.path(), OpenMode::kRead)); });
    CHECK(error.code() == ErrorCode::kCorruption);
    CHECK(names(error, {file.path().string(), std::to_string(bytes) + " bytes"}));
  }
  CHECK(error_of([&] {
          read_manifest(File(file.path().string() + "x", OpenMode::kRead));
        }).code() == ErrorCode::kNotFound);
}

TEST_CASE("DecodeManifest_FieldOutOfRangeWithTheRightChecksum_IsRefusedByName") {
  const auto refused = [](const ManifestSlot& slot, const char* field,
                          ErrorCode code = ErrorCode::kCorruption) {
    REQUIRE(is_whole_slot(slot));
    INFO(field);
    const Error error = error_of([&] { decode_manifest(slot, "the/manifest"); });
    CHECK(error.code() == code);
    CHECK(names(error, {"the/manifest", field}));
  };
  refused(forged(8, std::uint32_t{2}), "format version 2", ErrorCode::kNotSupported);
  refused(forged(8, std::uint32_t{4}), "format version 4", ErrorCode::kNotSupported);
  refused(forged(12, std::uint32_t{0x80000000u}), "required flag 31", ErrorCode::kNotSupported);
  refused(forged(12, std::uint32_t{32}), "knows only those of flags 0 to 4",
          ErrorCode::kNotSupported);
  refused(forged(40, std::uint64_t{0}), "sequence number is 0");
  refused(forged(40, kMaxSequence + 1), "sequence number");
}

/// Of a version with records in a change log.
Manifest manifest_with_log() {
  Manifest manifest = full_manifest();
  manifest.required_features = kChangeLog;
  manifest.described = manifest.sequence - 3;
  manifest.log = {manifest.described - 7, 0x777777000, 0x777770000, 0x1111111111111111u};
  return manifest;
}

TEST_CASE("DecodeManifest_OfAVersionWithAChangeLog_HasItsPlace") {
  const ManifestSlot slot = encode_manifest(manifest_with_log());
  CHECK(decode_manifest(slot, "manifest") == manifest_with_log());
  const auto refused = [&](auto change, const char* field) {
    Manifest manifest = manifest_with_log();
    change(manifest);
    INFO(field);
    const Error error =
        error_of([&] { decode_manifest(encode_manifest(manifest), "the/manifest"); });
    CHECK(error.code() == ErrorCode::kCorruption);
    CHECK(names(error, {"the/manifest", field}));
  };
  refused([](Manifest& m) { m.described = 0; }, "described version");
  refused([](Manifest& m) { m.described = m.sequence + 1; }, "described version");
  refused([](Manifest& m) { m.described -= kMostChangeRecords; }, "described version");
  refused([](Manifest& m) { m.log.generation = m.described + 1; }, "change log's version");
  refused([](Manifest& m) { m.log.bytes = ~std::uint64_t{0}; }, "size of the change log");
  refused([](Manifest& m) { m.log.last_record = 0; }, "place of the last record");
  refused([](Manifest& m) { m.log.last_record = m.log.bytes; }, "place of the last record");
  refused([](Manifest& m) { m.described = m.sequence; }, "place of the last record");
}

TEST_CASE("DecodeManifest_UnknownOptionalFlagsAndReservedBytes_AreIgnored") {
  Manifest with_all_known = full_manifest();
  with_all_known.optional_features = kKnownOptionalFeatures;
  CHECK(decode_manifest(forged(16, ~std::uint32_t{0}), "manifest") == with_all_known);
  CHECK(decode_manifest(forged(16, ~kKnownOptionalFeatures), "manifest") == full_manifest());
  CHECK(decode_manifest(forged(20, ~std::uint32_t{0}), "manifest") == full_manifest());
  CHECK(decode_manifest(forged(64, ~std::uint64_t{0}), "manifest") == full_manifest());
  CHECK(decode_manifest(forged(4080, ~std::uint64_t{0}), "manifest") == full_manifest());
}
