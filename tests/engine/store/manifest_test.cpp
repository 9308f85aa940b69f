// The manifest: what is written is read again, and nothing else is believed.
#include "store/manifest.h"

#include <catch2/catch.hpp>
#include <cstring>
#include <functional>

#include "engine/store/sample_store.h"
#include "plait/edge_index.h"
#include "store/byte_order.h"
#include "store/checksum.h"
#include "support/temporary_directory.h"

using namespace plait;
using namespace plait::test;

namespace {

/// Every field differs from every other and from zero.
Manifest full_manifest(std::size_t attributes) {
  Manifest manifest;
  for (std::size_t i = 0; i < manifest.uuid.size(); ++i)
    manifest.uuid[i] = static_cast<std::byte>(200 + i);
  manifest.sequence = 0x0123456789abcdefu;
  manifest.vertex_count = 0xfffffffeu;
  manifest.edge_count = 301;
  manifest.face_count = 302;
  manifest.border_edge_count = 303;
  manifest.block_bytes = 1u << 30;
  manifest.base_level = 2;
  manifest.next_attribute_number = 1000;
  manifest.base_mesh_bytes = 304;
  manifest.base_mesh_checksum = 0xfedcba9876543210u;
  manifest.tables_bytes = 305;
  manifest.tables_checksum = 0xfedcba9876543211u;
  manifest.backend = "fifteen-letters";
  manifest.codec = "zstd:19";
  manifest.filter = "shuffle";
  manifest.layout = "hilbert";
  manifest.scheme = "";
  for (std::size_t i = 0; i < attributes; ++i) {
    ManifestAttribute attribute;
    attribute.schema.name = "A-" + std::string(27, 'z') + (i < 10 ? "0" : "") + std::to_string(i);
    attribute.schema.type = static_cast<ComponentType>(1 + i % 10);
    attribute.schema.components = static_cast<std::uint32_t>(255 - i);
    attribute.number = static_cast<std::uint32_t>(999 - i);
    attribute.finest_level = 2 + static_cast<int>(i % 19);
    attribute.base_checksum = 0xaaaaaaaaaaaaaaaau + i;
    manifest.attributes.push_back(attribute);
  }
  return manifest;
}

void check_equal(const Manifest& a, const Manifest& b) {
  CHECK(a.uuid == b.uuid);
  CHECK(a.sequence == b.sequence);
  CHECK(a.vertex_count == b.vertex_count);
  CHECK(a.edge_count == b.edge_count);
  CHECK(a.face_count == b.face_count);
  CHECK(a.border_edge_count == b.border_edge_count);
  CHECK(a.block_bytes == b.block_bytes);
  CHECK(a.base_level == b.base_level);
  CHECK(a.next_attribute_number == b.next_attribute_number);
  CHECK(a.base_mesh_bytes == b.base_mesh_bytes);
  CHECK(a.base_mesh_checksum == b.base_mesh_checksum);
  CHECK(a.tables_bytes == b.tables_bytes);
  CHECK(a.tables_checksum == b.tables_checksum);
  CHECK(a.backend == b.backend);
  CHECK(a.codec == b.codec);
  CHECK(a.filter == b.filter);
  CHECK(a.layout == b.layout);
  CHECK(a.scheme == b.scheme);
  REQUIRE(a.attributes.size() == b.attributes.size());
  for (std::size_t i = 0; i < a.attributes.size(); ++i) {
    CHECK(a.attributes[i].schema == b.attributes[i].schema);
    CHECK(a.attributes[i].number == b.attributes[i].number);
    CHECK(a.attributes[i].finest_level == b.attributes[i].finest_level);
    CHECK(a.attributes[i].base_checksum == b.attributes[i].base_checksum);
  }
}

/// A manifest file with the versions `sequences`, in the slots that these say.
class ManifestFile {
 public:
  explicit ManifestFile(const std::vector<std::uint64_t>& sequences)
      : file_(path(), OpenMode::kCreate) {
    file_.resize(2 * kManifestSlotBytes);
    for (const std::uint64_t sequence : sequences) {
      Manifest manifest = full_manifest(3);
      manifest.sequence = sequence;
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
  ManifestSlot slot = encode_manifest(full_manifest(3));
  save(std::span<std::byte>(slot), offset, value);
  save(std::span<std::byte>(slot), 4088, checksum_of(std::span(slot).first(4088)));
  return slot;
}

}  // namespace

TEST_CASE("Manifest_AnyNumberOfAttributes_IsReadAsWritten") {
  for (const std::size_t attributes : {0u, 1u, 59u}) {
    const Manifest manifest = full_manifest(attributes);
    const ManifestSlot slot = encode_manifest(manifest);
    CHECK(is_whole_slot(slot));
    check_equal(decode_manifest(slot, "manifest"), manifest);
  }
}

TEST_CASE("EncodeManifest_WhatDoesNotFit_IsRefused") {
  const auto refused = [](const std::function<void(Manifest&)>& change, const char* word) {
    Manifest manifest = full_manifest(2);
    change(manifest);
    const Error error = error_of([&] { encode_manifest(manifest); });
    CHECK(error.code() == ErrorCode::kInvalidArgument);
    CHECK(names(error, {word}));
  };
  refused([](Manifest& m) { m = full_manifest(60); }, "60 attributes");
  const std::string sixteen(16, 'x');
  refused([&](Manifest& m) { m.backend = sixteen; }, "longer than 15");
  refused([&](Manifest& m) { m.codec = sixteen; }, "longer than 15");
  refused([&](Manifest& m) { m.filter = sixteen; }, "longer than 15");
  refused([&](Manifest& m) { m.layout = sixteen; }, "longer than 15");
  refused([&](Manifest& m) { m.scheme = sixteen; }, "longer than 15");
  for (const std::string& name : {std::string(), std::string(32, 'x'), std::string("a b"),
                                  std::string("a/b"), std::string("\xc3\xa4")})
    refused([&](Manifest& m) { m.attributes[1].schema.name = name; }, "no attribute name");
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
  refused(forged(12, std::uint32_t{0x80000000u}), "feature flags 0x80000000",
          ErrorCode::kNotSupported);
  refused(forged(20, std::uint32_t{60}), "number of attributes is 60");
  refused(forged(20, ~std::uint32_t{0}), "number of attributes");
  refused(forged(40, std::uint64_t{0}), "sequence number is 0");
  refused(forged(48, std::uint64_t{kNoId}), "vertex count is 4294967295");
  refused(forged(56, ~std::uint64_t{0}), "edge count");
  refused(forged(64, std::uint64_t{1} << 40), "face count");
  for (const std::uint64_t bytes : {0u, 2048u, 4097u, 12288u})
    refused(forged(80, std::uint64_t{bytes}), "block size");
  refused(forged(80, std::uint64_t{1} << 31), "block size");
  refused(forged(88, std::uint32_t{kMaxLevel + 1}), "base level is 21");
  refused(forged(88, ~std::uint32_t{0}), "base level");
  refused(forged(92, std::uint32_t{997}), "attribute number");
  for (const std::size_t offset : {128u, 144u, 160u, 176u, 192u}) {
    std::array<char, 16> text;
    text.fill('x');
    refused(forged(offset, text), "a name's length is 16");
  }
  constexpr std::size_t kSecond = 256 + 64;
  std::array<char, 32> name{};
  refused(forged(kSecond, name), "an attribute name is 1");
  name.fill('x');
  refused(forged(kSecond, name), "an attribute name is 1");
  name = {"../manifest"};
  refused(forged(kSecond, name), "an attribute name is 1");
  std::memcpy(name.data(), encode_manifest(full_manifest(3)).data() + 256, 32);
  refused(forged(kSecond, name), "repeated attribute name at entry is 1");
  refused(forged(kSecond + 32, std::uint32_t{999}), "attribute number is 999");
  refused(forged(kSecond + 32, std::uint32_t{1000}), "attribute number is 1000");
  refused(forged(kSecond + 36, std::uint32_t{1}), "finest level is 1");
  refused(forged(kSecond + 36, std::uint32_t{21}), "finest level is 21");
  refused(forged(kSecond + 40, std::uint8_t{0}), "record size");
  refused(forged(kSecond + 40, std::uint8_t{11}), "record size");
  refused(forged(kSecond + 41, std::uint8_t{0}), "record size");
}

TEST_CASE("DecodeManifest_OptionalFlagsAndReservedBytes_AreIgnored") {
  const Manifest expected = full_manifest(3);
  check_equal(decode_manifest(forged(16, ~std::uint32_t{0}), "manifest"), expected);
  check_equal(decode_manifest(forged(208, ~std::uint64_t{0}), "manifest"), expected);
  check_equal(decode_manifest(forged(256 + 56, ~std::uint64_t{0}), "manifest"), expected);
  check_equal(decode_manifest(forged(256 + 3 * 64, ~std::uint64_t{0}), "manifest"), expected);
}
