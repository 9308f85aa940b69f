#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <memory>
#include <random>
#include <vector>

#include "backends/conformance.h"
#include "compressed/codecs/packed_groups.h"
#include "plait/error.h"
#include "plait/extend/pipeline_registry.h"
#include "plait/registry.h"
#include "rows/every_target.h"

namespace plait::test {
namespace {

constexpr const char* kCodecs[] = {"none",   "lz4",     "bitpack", "zstd",
                                   "zstd:1", "zstd:-5", "zstd:19"};
constexpr std::size_t kSizes[] = {0,   1,   2,    7,    12,    13,    64,
                                  255, 256, 4095, 4096, 32768, 65536, 70000};

/// A copy in a heap block of exactly its size, so that the address sanitizer sees one byte too far.
struct ExactBuffer {
  explicit ExactBuffer(std::size_t count) : bytes(new std::byte[count]), size(count) {}
  explicit ExactBuffer(std::span<const std::byte> from) : ExactBuffer(from.size()) {
    std::ranges::copy(from, bytes.get());
  }
  std::span<std::byte> span() { return {bytes.get(), size}; }

  std::unique_ptr<std::byte[]> bytes;
  std::size_t size;
};

std::unique_ptr<Codec> codec_of(const char* pipeline) {
  return default_pipelines().make_codec(Pipeline(pipeline).codec);
}

/// Whether `stored` decodes to exactly `raw_bytes` bytes; any error but kCorruption fails.
bool decodes(Codec& codec, std::span<const std::byte> stored, std::size_t raw_bytes) {
  ExactBuffer from(stored), into(raw_bytes);
  try {
    codec.decompress(from.span(), into.span());
    return true;
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::kCorruption);
    return false;
  }
}

}  // namespace

TEST_CASE("Codec_AnyContentOfAnySize_RoundTrips") {
  for (const char* name : kCodecs) {
    const auto codec = codec_of(name);
    for (const std::size_t size : kSizes) {
      for (const Content content : {Content::kZeros, Content::kSmooth, Content::kRandom}) {
        INFO(name << ' ' << size);
        ExactBuffer raw(make_content(size, content, 1));
        ExactBuffer room(codec->bound(size));
        const auto stored_bytes = codec->compress(raw.span(), room.span());
        REQUIRE(stored_bytes);
        REQUIRE(*stored_bytes <= room.size);
        ExactBuffer stored(room.span().first(*stored_bytes));
        ExactBuffer back(size);
        codec->decompress(stored.span(), back.span());
        CHECK(std::ranges::equal(raw.span(), back.span()));
      }
    }
  }
}

TEST_CASE("CodecCompress_TooLittleRoom_GivesNothingAndOverrunsNothing") {
  for (const char* name : kCodecs) {
    const auto codec = codec_of(name);
    for (const std::size_t size : {100u, 4096u, 70000u}) {
      INFO(name << ' ' << size);
      ExactBuffer raw(make_content(size, Content::kRandom, 2));
      for (const std::size_t room_bytes : {std::size_t{0}, std::size_t{1}, size / 2, size - 1}) {
        ExactBuffer room(room_bytes);
        CHECK_FALSE(codec->compress(raw.span(), room.span()));
      }
    }
  }
}

TEST_CASE("CodecCompress_WhateverItDidBefore_GivesTheSameBytes") {
  for (const char* name : kCodecs) {
    const auto used = codec_of(name);
    std::minstd_rand random(4);
    for (int turn = 0; turn < 60; ++turn) {
      const std::size_t size = kSizes[random() % std::size(kSizes)];
      const auto content = std::array{Content::kSmooth, Content::kRandom}[random() % 2];
      CAPTURE(name, turn, size);
      ExactBuffer raw(make_content(size, content, static_cast<std::uint32_t>(turn)));
      ExactBuffer found(used->bound(size)), expected(used->bound(size));
      const auto found_bytes = used->compress(raw.span(), found.span());
      REQUIRE(found_bytes == codec_of(name)->compress(raw.span(), expected.span()));
      REQUIRE(std::ranges::equal(found.span().first(*found_bytes),
                                 expected.span().first(*found_bytes)));
      // A block that does not fit, as blocks of noise do not, leaves nothing behind either.
      if (size > 0) CHECK_FALSE(used->compress(raw.span(), found.span().first(*found_bytes / 2)));
    }
  }
}

TEST_CASE("Bitpack_AFewWords_HaveTheBytesOfThePage") {
  const std::uint32_t words[] = {1, 0, 5};
  const auto raw = std::as_bytes(std::span(words));
  std::vector<std::byte> stored(64);
  const auto codec = codec_of("bitpack");
  REQUIRE(codec->compress(raw, stored) == 7);
  stored.resize(7);
  const std::vector<std::byte> expected = {std::byte{2},   std::byte{3}, std::byte{0},
                                           std::byte{0},   std::byte{0}, std::byte{0x41},
                                           std::byte{0x01}};
  CHECK(stored == expected);
}

TEST_CASE("Bitpack_WidthsThatNoEncoderWrites_AreRefusedInWords") {
  const auto codec = codec_of("bitpack");
  const std::vector<std::byte> zeros(64);
  std::vector<std::byte> stored(codec->bound(64)), back(64);
  // All zero: one group, and no bits for its width.
  REQUIRE(codec->compress(zeros, stored) == 1);
  const auto refusal_of = [&](std::vector<std::byte> bytes) -> std::string {
    try {
      codec->decompress(bytes, back);
      return "none";
    } catch (const Error& error) {
      CHECK(error.code() == ErrorCode::kCorruption);
      return error.what();
    }
  };
  CHECK(refusal_of({std::byte{0}}) == "none");
  CHECK_THAT(refusal_of({}), Catch::Contains("expected widths of 1 bytes, found 0"));
  CHECK_THAT(refusal_of({std::byte{7}}),
             Catch::Contains("expected widths of at most 6 bits, found 7"));
  CHECK_THAT(refusal_of({std::byte{6}}), Catch::Contains("expected widths of 12 bytes, found 0"));
  // Sixteen widths of 6 bits, the first of them 33.
  std::vector<std::byte> wide(13);
  wide[0] = std::byte{6}, wide[1] = std::byte{33};
  CHECK_THAT(refusal_of(wide), Catch::Contains("expected widths of at most 32 bits, found 33"));
  wide[1] = std::byte{1};
  CHECK_THAT(refusal_of(wide), Catch::Contains("expected 15 bytes, found 13"));
  wide.resize(15);
  CHECK(refusal_of(wide) == "none");
  wide.resize(16);
  CHECK_THAT(refusal_of(wide), Catch::Contains("expected 15 bytes, found 16"));
}

TEST_CASE("CodecDecompress_CutOrOfAnotherSize_IsCorruption") {
  for (const char* name : kCodecs) {
    const auto codec = codec_of(name);
    for (const Content content : {Content::kZeros, Content::kSmooth, Content::kRandom}) {
      const std::size_t size = 5000;
      ExactBuffer raw(make_content(size, content, 3));
      ExactBuffer room(codec->bound(size));
      const auto stored = room.span().first(codec->compress(raw.span(), room.span()).value());
      INFO(name);
      REQUIRE(decodes(*codec, stored, size));
      const std::size_t step = stored.size() / 200 + 1;
      for (std::size_t cut = 0; cut < stored.size(); cut += step)
        CHECK_FALSE(decodes(*codec, stored.first(cut), size));
      for (const std::size_t other : {std::size_t{0}, std::size_t{1}, size - 1, size + 1, 2 * size})
        CHECK_FALSE(decodes(*codec, stored, other));
    }
  }
}

TEST_CASE("CodecDecompress_GarbageOrFlippedBits_NeverOverruns") {
  std::minstd_rand random(4);
  std::uint32_t seed = 0;
  for (const char* name : kCodecs) {
    const auto codec = codec_of(name);
    for (int round = 0; round < 200; ++round) {
      const auto garbage = make_content(random() % 300, Content::kRandom, seed++);
      decodes(*codec, garbage, random() % 2000);
    }
    const std::size_t size = 3000;
    ExactBuffer raw(make_content(size, Content::kSmooth, 5));
    ExactBuffer room(codec->bound(size));
    ExactBuffer stored(room.span().first(codec->compress(raw.span(), room.span()).value()));
    for (int round = 0; round < 500; ++round) {
      const std::size_t place = random() % stored.size;
      const auto flip = static_cast<std::byte>(1u << random() % 8);
      stored.bytes[place] ^= flip;
      decodes(*codec, stored.span(), size);
      stored.bytes[place] ^= flip;
    }
    CHECK(decodes(*codec, stored.span(), size));  // errors leave the codec usable
  }
}

TEST_CASE("ZstdCompress_PartsOfSeveralKinds_EachTakeTheirOwnWay") {
  // Noise of five bits has no matches, and a repeated text of all bytes has nothing else.
  const std::size_t size = 160'000;
  ExactBuffer raw(make_content(size, Content::kRandom, 6));
  for (std::size_t i = 0; i < size / 2; ++i) raw.bytes[i] &= std::byte{31};
  for (std::size_t i = size / 2 + 1000; i < size; ++i) raw.bytes[i] = raw.bytes[i - 1000];
  for (const char* name : {"zstd:1", "zstd:9"}) {
    const auto codec = codec_of(name);
    ExactBuffer room(codec->bound(size));
    const auto stored = room.span().first(codec->compress(raw.span(), room.span()).value());
    CHECK(stored.size() < size / 2 * 5 / 8 + size / 2 / 8);
    ExactBuffer back(size);
    codec->decompress(stored, back.span());
    CHECK(std::ranges::equal(raw.span(), back.span()));
    CHECK_FALSE(decodes(*codec, stored.first(stored.size() - 1), size));
    std::vector<std::byte> longer(stored.begin(), stored.end());
    longer.push_back(std::byte{0});
    CHECK_FALSE(decodes(*codec, longer, size));
  }
}

TEST_CASE("ZstdDecompress_SeveralFramesThatAddUp_IsRefused") {
  const auto codec = codec_of("zstd");
  ExactBuffer raw(make_content(1000, Content::kZeros, 0));
  ExactBuffer room(codec->bound(raw.size));
  const auto frame = room.span().first(codec->compress(raw.span(), room.span()).value());
  std::vector<std::byte> frames(frame.begin(), frame.end());
  REQUIRE(decodes(*codec, frames, 1000));
  frames.insert(frames.end(), frame.begin(), frame.end());
  CHECK_FALSE(decodes(*codec, frames, 2000));
  CHECK_FALSE(decodes(*codec, frames, 1000));
}

// packed_groups.h: its bits are those of docs/filters/bitpack.md, on every instruction set, and no
// byte outside the packed ones is read.

namespace {

/// The definition: bit b of word i of a group is bit i * width + b of the group.
std::vector<std::byte> packed_by_definition(const std::vector<std::uint32_t>& words,
                                            const std::vector<std::uint32_t>& widths) {
  std::vector<bool> bits;
  for (std::size_t i = 0; i < words.size(); ++i)
    for (std::uint32_t bit = 0; bit < widths[i / kGroupWords]; ++bit)
      bits.push_back((words[i] >> bit & 1) != 0);
  std::vector<std::byte> packed(bits.size() / 8);
  for (std::size_t i = 0; i < bits.size(); ++i)
    if (bits[i]) packed[i / 8] |= std::byte{1} << i % 8;
  return packed;
}

}  // namespace

TEST_CASE("PackedGroups_OnEveryInstructionSet_AreTheirDefinitionAndInverse") {
  fused_rows::on_every_target([](const char* target) {
    std::mt19937 generator(3);
    const auto random = [&] { return static_cast<std::uint32_t>(generator()); };
    for (std::size_t groups : {0u, 1u, 2u, 3u, 7u, 33u, 200u}) {
      for (int turn = 0; turn < 20; ++turn) {
        CAPTURE(target, groups, turn);
        std::vector<std::uint32_t> words(groups * kGroupWords), expected_widths(groups);
        for (std::size_t group = 0; group < groups; ++group) {
          // Each width in turn, then any; the largest word is at any place.
          const std::uint32_t width =
              turn == 0 ? static_cast<std::uint32_t>(group % 33) : random() % 33;
          expected_widths[group] = width;
          for (std::size_t i = 0; i < kGroupWords && width > 0; ++i)
            words[group * kGroupWords + i] = random() >> (32 - width);
          if (width > 0) words[group * kGroupWords + random() % kGroupWords] |= 1u << (width - 1);
        }
        const auto* const bytes = reinterpret_cast<const std::byte*>(words.data());
        std::vector<std::uint32_t> widths(groups);
        find_widths(bytes, groups, widths.data());
        REQUIRE(widths == expected_widths);
        const std::vector<std::byte> expected = packed_by_definition(words, widths);
        // Of exactly its size, so that the address sanitizer sees one byte too far.
        const auto packed = std::make_unique<std::byte[]>(expected.size());
        pack_groups(bytes, groups, widths.data(), packed.get());
        REQUIRE(std::equal(expected.begin(), expected.end(), packed.get()));
        std::vector<std::uint32_t> back(words.size(), 0xcccccccc);
        unpack_groups(packed.get(), expected.size(), widths.data(), groups,
                      reinterpret_cast<std::byte*>(back.data()));
        REQUIRE(back == words);
      }
    }
  });
}

}  // namespace plait::test
