// The description of a version: what is written is read again, and nothing else is believed.
#include "format/version_description.h"

#include <catch2/catch.hpp>
#include <functional>

#include "engine/store/sample_store.h"
#include "format/byte_order.h"
#include "format/manifest.h"
#include "format/version_file.h"
#include "plait/extend/edge_index.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"

using namespace plait;
using namespace plait::test;

namespace {

constexpr std::uint64_t kSequence = 40;

/// Every field differs from every other and from zero.
VersionDescription full_description(std::size_t attributes) {
  VersionDescription version;
  version.vertex_count = 0xfffffffeu;
  version.edge_count = 301;
  version.face_count = 302;
  version.border_edge_count = 303;
  version.block_bytes = 1u << 30;
  version.next_attribute_number = 100'000;
  version.base_mesh_bytes = 304;
  version.base_mesh_checksum = 0xfedcba9876543210u;
  version.backend = "mine";
  version.pipeline = "shuffle,zstd:19";
  version.provenance = {
      std::string(kMaxTextBytes, 's'), true, ComponentType::kFloat64, "hilbert", 2, "10.20.30"};
  for (std::size_t i = 0; i < attributes; ++i) {
    AttributeRecord attribute;
    attribute.schema.name = "A-" + std::string(i == 0 ? 252 : 20, 'z') + std::to_string(i);
    attribute.schema.type = static_cast<ComponentType>(1 + i % 10);
    attribute.schema.components = static_cast<std::uint32_t>(255 - i % 250);
    attribute.number = static_cast<std::uint32_t>(99'999 - i);
    attribute.base_bytes = i;
    attribute.base_checksum = 0xaaaaaaaaaaaaaaaau + i;
    attribute.pipeline = "lz4";
    for (std::size_t level = 0; level < i % 19; ++level)
      attribute.levels.push_back(
          {level < 3 ? "none" : "shuffle,lz4", Representation::kValues, 1 + level});
    version.attributes.push_back(attribute);
  }
  return version;
}

void check_equal(const VersionDescription& a, const VersionDescription& b) {
  CHECK(a.vertex_count == b.vertex_count);
  CHECK(a.edge_count == b.edge_count);
  CHECK(a.face_count == b.face_count);
  CHECK(a.border_edge_count == b.border_edge_count);
  CHECK(a.block_bytes == b.block_bytes);
  CHECK(a.next_attribute_number == b.next_attribute_number);
  CHECK(a.base_mesh_bytes == b.base_mesh_bytes);
  CHECK(a.base_mesh_checksum == b.base_mesh_checksum);
  CHECK(a.backend == b.backend);
  CHECK(a.pipeline == b.pipeline);
  CHECK(a.provenance == b.provenance);
  REQUIRE(a.attributes.size() == b.attributes.size());
  bool same = true;
  for (std::size_t i = 0; i < a.attributes.size(); ++i)
    same = same && a.attributes[i].schema == b.attributes[i].schema &&
           a.attributes[i].number == b.attributes[i].number &&
           a.attributes[i].base_bytes == b.attributes[i].base_bytes &&
           a.attributes[i].base_checksum == b.attributes[i].base_checksum &&
           a.attributes[i].pipeline == b.attributes[i].pipeline &&
           a.attributes[i].levels == b.attributes[i].levels;
  CHECK(same);
}

VersionDescription decode(std::span<const std::byte> bytes) {
  return decode_description(bytes, kSequence, "the/version.40");
}

/// `value` at the place of a description where `marker` is the only run of such bytes.
template <class Value>
std::vector<std::byte> forged_description(const VersionDescription& version,
                                          std::string_view marker, std::ptrdiff_t distance,
                                          Value value) {
  std::vector<std::byte> bytes = encode_description(version);
  const auto text = std::as_bytes(std::span(marker));
  const auto found = std::ranges::search(bytes, text);
  REQUIRE(!found.empty());
  const auto at = found.begin() - bytes.begin() + distance;
  save(std::span(bytes), static_cast<std::size_t>(at), value);
  return bytes;
}

void check_refused(std::span<const std::byte> bytes, const std::vector<std::string>& words,
                   ErrorCode code = ErrorCode::kCorruption) {
  const Error error = error_of([&] { decode(bytes); });
  CHECK(error.code() == code);
  CHECK(names(error, {"the/version.40"}));
  CHECK(names(error, words));
}

}  // namespace

TEST_CASE("Description_AnyNumberOfAttributes_IsReadAsWritten") {
  for (const std::size_t attributes : {0u, 1u, 60u, 1000u}) {
    const VersionDescription version = full_description(attributes);
    check_equal(decode(encode_description(version)), version);
  }
}

TEST_CASE("Description_OfDepths_IsReadAsWrittenOrRefused") {
  VersionDescription version = full_description(2);
  version.shards = {};
  const auto deepest = static_cast<std::size_t>(kMaxLevel - version.provenance.base_level);
  version.depths = {7, std::vector<std::uint32_t>(deepest, 3)};
  const auto decode_depths = [&] {
    return decode_description(encode_description(version), kSequence, "the/version.40",
                              optional_features_of(version), required_features_of(version));
  };
  CHECK(required_features_of(version) == kDepths);
  CHECK(decode_depths().depths == version.depths);
  const auto refused = [&](std::vector<std::uint32_t> slots) {
    version.depths->slots = std::move(slots);
    CHECK(error_of([&] { decode_depths(); }).code() == ErrorCode::kCorruption);
  };
  refused(std::vector<std::uint32_t>(deepest + 1, 3));
  refused({});  // fewer levels than an attribute has
  std::vector<std::uint32_t> slots(deepest, 3);
  slots.back() = 0;
  refused(slots);
  slots.back() = 4;
  refused(slots);
  refused(std::vector<std::uint32_t>(deepest, static_cast<std::uint32_t>(version.edge_count) + 1));
}

TEST_CASE("Description_OfShards_IsReadAsWrittenOrRefused") {
  VersionDescription version = full_description(2);
  version.shards = {{0, 1}, {1, 0xffff'ffff'ffff'ffff}, {static_cast<EdgeId>(7), 3}};
  REQUIRE(version.edge_count > 7);
  const auto decode_shards = [&](std::span<const std::byte> bytes) {
    return decode_description(bytes, kSequence, "the/version.40", optional_features_of(version),
                              required_features_of(version));
  };
  const std::vector<std::byte> bytes = encode_description(version);
  CHECK(required_features_of(version) == kShards);
  CHECK(decode_shards(bytes).shards == version.shards);
  CHECK_FALSE(decode_shards(bytes).shares_files);
  version.shares_files = true;
  CHECK(encode_description(version) == bytes);  // the flag alone says so
  CHECK(required_features_of(version) == (kShards | kSharedFiles));
  CHECK(decode_shards(bytes).shares_files);
  CHECK(error_of([&] {
          decode_description(encode_description(full_description(2)), kSequence, "the/version.40",
                             optional_features_of(version), kSharedFiles);
        }).code() == ErrorCode::kCorruption);
  version.shares_files = false;
  for (std::size_t missing = 1; missing <= 40; ++missing)
    CHECK(error_of([&] { decode_shards(std::span(bytes).first(bytes.size() - missing)); }).code() ==
          ErrorCode::kCorruption);
  const auto refused = [&](std::vector<ShardRecord> shards) {
    version.shards = std::move(shards);
    CHECK(error_of([&] { decode_shards(encode_description(version)); }).code() ==
          ErrorCode::kCorruption);
  };
  refused({{1, 0}});
  refused({{0, 0}, {0, 0}});
  refused({{0, 0}, {5, 0}, {4, 0}});
  refused({{0, 0}, {static_cast<EdgeId>(version.edge_count), 0}});
}

TEST_CASE("EncodeDescription_WhatDoesNotFit_IsRefused") {
  const auto refused = [](const std::function<void(VersionDescription&)>& change,
                          const char* word) {
    VersionDescription version = full_description(2);
    change(version);
    const Error error = error_of([&] { encode_description(version); });
    CHECK(error.code() == ErrorCode::kInvalidArgument);
    CHECK(names(error, {word}));
  };
  const std::string too_long(kMaxTextBytes + 1, 'x');
  refused([&](auto& v) { v.backend = too_long; }, "the backend");
  refused([&](auto& v) { v.pipeline = too_long; }, "the pipeline");
  refused([&](auto& v) { v.provenance.layout = too_long; }, "the layout");
  refused([&](auto& v) { v.provenance.scheme = too_long; }, "found 65537 bytes");
  refused([&](auto& v) { v.provenance.program = "1.0\n"; }, "not all of them printable");
  refused([&](auto& v) { v.attributes[1].pipeline = too_long; }, "pipeline");
  for (const std::string& name : {std::string(), std::string(256, 'x'), std::string("a b"),
                                  std::string("a/b"), std::string("\xc3\xa4")})
    refused([&](auto& v) { v.attributes[1].schema.name = name; }, "no attribute name");
  refused([](auto& v) { v.attributes.resize(kMaxAttributes + 1); }, "65536");
}

TEST_CASE("DecodeDescription_CutAnywhere_IsRefusedAndBytesBehindItAreIgnored") {
  const VersionDescription version = full_description(8);
  std::vector<std::byte> bytes = encode_description(version);
  for (std::size_t size = 0; size < bytes.size(); size += size < 300 || size > 66'000 ? 1 : 97)
    check_refused(std::span(bytes).first(size), {"open"});
  bytes.insert(bytes.end(), 1000, std::byte{0xee});
  check_equal(decode(bytes), version);
}

TEST_CASE("DecodeDescription_FieldOutOfRange_IsRefusedByName") {
  const VersionDescription version = full_description(4);
  const std::vector<std::byte> bytes = encode_description(version);
  const auto refused = [&](std::size_t offset, auto value, const std::string& field) {
    std::vector<std::byte> forged_description = bytes;
    save(std::span(forged_description), offset, value);
    check_refused(forged_description, {field});
  };
  refused(0, std::uint64_t{kNoId}, "the vertex count is 4294967295");
  refused(8, ~std::uint64_t{0}, "the edge count");
  refused(16, std::uint64_t{1} << 40, "the face count");
  refused(24, std::uint64_t{1} << 32, "the border edge count");
  for (const std::uint64_t size :
       {std::uint64_t{0}, std::uint64_t{2048}, std::uint64_t{4097}, std::uint64_t{1} << 31})
    refused(32, size, "the block size");
  refused(56, std::uint32_t{kMaxLevel + 1}, "the base level is 21");
  refused(56, ~std::uint32_t{0}, "the base level");
  refused(60, std::uint32_t{99'998}, "an attribute's number");
  // Lengths that would take memory are refused before any is taken.
  for (const std::uint32_t length : {65'537u, 0x7fffffffu, 0xffffffffu})
    refused(64, length, "the length of the backend");
  refused(64, std::uint32_t{65'000}, "not printable");
  refused(68, std::uint8_t{7}, "a character of the backend");
}

TEST_CASE("DecodeDescription_AttributeOutOfRange_IsRefusedByName") {
  VersionDescription version = full_description(2);
  version.attributes[1].schema.name = "second";
  version.attributes[1].pipeline = "marker";
  const auto at_name = [&](std::ptrdiff_t distance, auto value) {
    return forged_description(version, "second", distance, value);
  };
  check_refused(at_name(0, '/'), {"an attribute's name is /econd"});
  check_refused(at_name(-4, std::uint32_t{256}), {"the length of an attribute's name"});
  check_refused(at_name(6, std::uint32_t{99'999}), {"an attribute's number is 99999"});
  check_refused(at_name(6, std::uint32_t{100'000}), {"an attribute's number is 100000"});
  check_refused(at_name(10, std::uint8_t{0}), {"a record's size"});
  check_refused(at_name(10, std::uint8_t{11}), {"a record's size"});
  check_refused(at_name(11, std::uint8_t{0}), {"a record's size"});
  const auto at_levels = [&](std::ptrdiff_t distance, auto value) {
    return forged_description(version, "marker", 6 + distance, value);
  };
  check_refused(at_levels(0, std::uint32_t{19}), {"a number of levels is 19"});
  check_refused(at_levels(0, ~std::uint32_t{0}), {"a number of levels"});
  check_refused(at_levels(4, std::uint32_t{2}), {"a number of ranges of levels is 2"});
  check_refused(at_levels(4, std::uint32_t{0}), {"the number of levels in all ranges is 0"});
  check_refused(at_levels(8, std::uint32_t{0}), {"the size of a range of levels is 0"});
  check_refused(at_levels(8, std::uint32_t{2}), {"the size of a range of levels is 2"});
  check_refused(at_levels(12, std::uint32_t{1}),
                {"'second'", "level 3", "representation 1", "only 0"}, ErrorCode::kNotSupported);
  check_refused(at_levels(24, std::uint64_t{0}), {"a level's generation is 0"});
  check_refused(at_levels(24, kSequence + 1), {"a level's generation is 41"});
  check_refused(at_levels(32, std::uint32_t{1}), {"a level's other files is 1"});
  version.attributes[1].schema.name = version.attributes[0].schema.name;
  check_refused(encode_description(version), {"a repeated attribute name"});
}

TEST_CASE("DecodeDescription_MoreAttributesThanBytes_IsRefusedBeforeMemoryIsTaken") {
  const VersionDescription version = full_description(0);
  std::vector<std::byte> bytes = encode_description(version);
  for (const std::uint32_t count : {1u, 65535u, 65536u, 0xffffffffu}) {
    save(std::span(bytes), bytes.size() - 4, count);
    check_refused(bytes, {"the number of attributes is " + std::to_string(count)});
  }
}

TEST_CASE("ReadDescription_HeaderThatPromisesTooMuch_IsRefused") {
  const TemporaryDirectory directory;
  const Directory store(directory.path());
  const std::vector<std::byte> right =
      encode_version_file(encode_description(full_description(2)), {});
  int number = 0;
  const auto read = [&](std::vector<std::byte> bytes) {
    const std::string name = "version." + std::to_string(++number);
    File file(store, name, OpenMode::kCreate);
    file.write_at(0, bytes);
    return read_description(file);
  };
  CHECK(read(right).size() == right.size() - 32);
  const auto refused = [&](std::size_t offset, auto value, const char* word) {
    std::vector<std::byte> forged_description = right;
    save(std::span(forged_description), offset, value);
    const Error error = error_of([&] { read(forged_description); });
    CHECK(error.code() == ErrorCode::kCorruption);
    CHECK(names(error, {word}));
  };
  refused(0, 'x', "header");
  refused(8, 2u, "header");
  refused(16, std::uint64_t{right.size() - 31}, "description of at most");
  refused(16, ~std::uint64_t{0}, "description of at most");
  refused(24, std::uint64_t{1}, "checksum");
  refused(40, 'x', "checksum");
  CHECK(error_of([&] { read(std::vector<std::byte>(31)); }).code() == ErrorCode::kCorruption);
}
