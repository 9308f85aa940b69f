// Packed base records: any bits come back, and files that would take memory are refused.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include "format/base_records_file.h"

namespace plait::test {
namespace {

using Bytes = std::vector<std::byte>;
using Positions = std::vector<Vector3<double>>;

AttributeSchema schema(const char* name, ComponentType type, std::uint32_t components) {
  return {name, type, components};
}

Bytes decoded(const AttributeSchema& schema, const Bytes& file, const Positions& positions,
              std::size_t bytes) {
  Bytes records(bytes);
  const auto reason = decode_base_records(schema, file, positions, records);
  INFO(reason.value_or(""));
  REQUIRE(!reason);
  return records;
}

/// Numbers that neighbours share most of, so that packing pays.
Bytes smooth_records(const AttributeSchema& schema, std::size_t count) {
  Bytes bytes(count * schema.record_bytes());
  for (std::size_t v = 0; v < count; ++v)
    for (std::uint32_t c = 0; c < schema.components; ++c) {
      const std::size_t width = component_bytes(schema.type),
                        at = v * schema.record_bytes() + c * width;
      const float narrow = 1 + static_cast<float>(v + c) / 4096;
      const double wide = 1 + static_cast<double>(v + c) / 4096;
      const std::uint64_t whole = 3 * v + c;
      if (schema.type == ComponentType::kFloat32)
        std::memcpy(&bytes[at], &narrow, 4);
      else if (schema.type == ComponentType::kFloat64)
        std::memcpy(&bytes[at], &wide, 8);
      else
        std::memcpy(&bytes[at], &whole, width);
    }
  return bytes;
}

}  // namespace

TEST_CASE("BaseRecords_OfEachType_TakeFewerBytesAndComeBack") {
  constexpr std::size_t kCount = 1000;
  for (int type = 1; type <= 10; ++type)
    for (const std::uint32_t components : {1u, 3u, 5u}) {
      const AttributeSchema one = schema("heat", static_cast<ComponentType>(type), components);
      CAPTURE(type, components);
      const Bytes records = smooth_records(one, kCount);
      const Bytes file = encode_base_records(one, records, {});
      CHECK(file.size() < records.size());
      CHECK(decoded(one, file, {}, records.size()) == records);
    }
}

TEST_CASE("BaseRecords_ThatAreTheBaseMesh_TakeNextToNothing") {
  for (const ComponentType type : {ComponentType::kFloat32, ComponentType::kFloat64}) {
    const AttributeSchema position = schema("position", type, 3);
    REQUIRE(follows_base_positions(position));
    std::mt19937 random(1);
    Positions positions(500);
    for (auto& p : positions)
      p = {1e-3 * static_cast<double>(random()), -1e-6 * static_cast<double>(random()), 0.1};
    Bytes records(positions.size() * position.record_bytes());
    for (std::size_t v = 0; v < positions.size(); ++v) {
      const std::array<double, 3> wide = {positions[v].x, positions[v].y, positions[v].z};
      const std::array<float, 3> narrow = {static_cast<float>(wide[0]), static_cast<float>(wide[1]),
                                           static_cast<float>(wide[2])};
      if (type == ComponentType::kFloat32)
        std::memcpy(&records[v * 12], narrow.data(), 12);
      else
        std::memcpy(&records[v * 24], wide.data(), 24);
    }
    const Bytes file = encode_base_records(position, records, positions);
    CHECK(file.size() < 32);
    CHECK(decoded(position, file, positions, records.size()) == records);
    // Other bits, NaN, infinities and -0 among them, come back too.
    const float odd[] = {std::numeric_limits<float>::quiet_NaN(),
                         -std::numeric_limits<float>::infinity(), -0.0F};
    std::memcpy(&records[24], odd, sizeof odd);
    CHECK(decoded(position, encode_base_records(position, records, positions), positions,
                  records.size()) == records);
  }
}

TEST_CASE("BaseRecords_OfNoise_AreStoredAsTheyAre") {
  const AttributeSchema noise = schema("noise", ComponentType::kUint32, 3);
  std::mt19937 random(1);
  Bytes records(12000);
  std::ranges::generate(records, [&] { return static_cast<std::byte>(random()); });
  CHECK(encode_base_records(noise, records, {}) == records);
  CHECK(decoded(noise, records, {}, records.size()) == records);
}

TEST_CASE("BaseRecords_OfManyZeros_AreNotPackedSoThatTheyCouldTakeMemory") {
  const AttributeSchema wide = schema("wide", ComponentType::kUint64, 255);
  const Bytes small(20'400), large(2'040'000);
  CHECK(encode_base_records(wide, small, {}).size() < 64);
  CHECK(encode_base_records(wide, large, {}) == large);
  // A frame that somebody else made of them.
  const AttributeSchema position = schema("position", ComponentType::kFloat32, 3);
  const Positions zeros(large.size() / 12);
  Bytes file = encode_base_records(position, Bytes(12 * zeros.size()), zeros);
  REQUIRE(file.size() < large.size() / 64);
  Bytes records(12 * zeros.size());
  CHECK(!decode_base_records(position, file, zeros, records));
  const AttributeSchema other = schema("other", ComponentType::kFloat32, 3);
  CHECK(decode_base_records(other, file, {}, records)->find("1/64") != std::string::npos);
}

TEST_CASE("BaseRecords_FilesThatAreNoFrameOfTheRecords_AreRefused") {
  const AttributeSchema heat = schema("heat", ComponentType::kFloat32, 1);
  const Bytes records = smooth_records(heat, 300);
  const Bytes file = encode_base_records(heat, records, {});
  REQUIRE(file.size() < records.size());
  Bytes room(records.size());
  const auto is_refused = [&](Bytes bytes, std::size_t size) {
    Bytes into(size);
    return decode_base_records(heat, bytes, {}, into).has_value();
  };
  CHECK_FALSE(is_refused(file, records.size()));
  for (std::size_t cut = 0; cut < file.size(); ++cut)
    CHECK(is_refused({file.begin(), file.begin() + static_cast<std::ptrdiff_t>(cut)},
                     records.size()));
  Bytes longer = file;
  longer.push_back(std::byte{0});
  CHECK(is_refused(longer, records.size()));
  CHECK(is_refused(file, records.size() + 4));
  CHECK(is_refused(file, records.size() - 4));
}

}  // namespace plait::test
