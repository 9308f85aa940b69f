// What only the compressed backend does; the rest is in backends/conformance/.
#include <algorithm>
#include <catch2/catch.hpp>
#include <utility>

#include "backends/conformance.h"
#include "compressed/block_coder.h"
#include "compressed/codec_time.h"
#include "plait/error.h"
#include "plait/registry.h"

namespace plait::test {
namespace {

BackendUnderTest compressed(const std::string& pipeline) {
  return {pipeline, default_backends().find("compressed"), pipeline};
}

}  // namespace

TEST_CASE("BlockCoder_SavesLessThanAnEighth_StaysRaw") {
  CHECK(max_encoded_bytes(0) == 0);
  CHECK(max_encoded_bytes(1) == 0);
  CHECK(max_encoded_bytes(8) == 7);
  CHECK(max_encoded_bytes(9) == 7);
  CHECK(max_encoded_bytes(4096) == 3584);

  const std::size_t size = 4096;
  const Filters none;
  BlockCoder coder(default_pipelines().make_codec({"lz4"}), size, 0, 0);
  std::size_t encoded_count = 0;
  for (std::size_t zeros = 0; zeros <= size; zeros += 16) {
    auto raw = make_content(size, Content::kRandom, 1);
    std::fill_n(raw.begin(), zeros, std::byte{0});
    const EncodedBlock block = coder.encode({none}, raw);
    if (block.encoding == BlockEncoding::kRaw) {
      CHECK(block.bytes.data() == raw.data());
      CHECK(zeros <= size / 8 + 64);  // lz4 itself takes a few bytes
    } else {
      ++encoded_count;
      CHECK(block.bytes.size() * 8 <= size * 7);
      CHECK(zeros >= size / 8);
      std::vector<std::byte> back(size);
      coder.decode({none}, block.bytes, back);
      CHECK(back == raw);
    }
  }
  CHECK(encoded_count > 200);
}

TEST_CASE("CompressedBackend_SmoothFloats_TakeLessThanRawAndLessStillShuffled") {
  std::uint64_t stored_bytes[2] = {};
  for (const bool shuffled : {false, true}) {
    const auto subject = compressed(shuffled ? "shuffle,lz4" : "lz4");
    LevelUnderTest level(subject, {64, {}, 6, 12, 1 << 16});
    Backend& backend = level.open();
    const auto bytes = make_content(level.geometry().total_bytes(), Content::kSmooth, 1);
    backend.write({0, level.geometry().block_count()}, bytes);
    stored_bytes[shuffled] = backend.stored_bytes();
    for (const BlockEntry& entry : level.table().entries()) {
      CHECK(entry.offset % 512 == 0);
      if (shuffled) CHECK(entry.encoding == BlockEncoding::kEncoded);
    }
    CHECK(backend.stored_bytes() >= std::filesystem::file_size(level.file()));
    CHECK(backend.stored_bytes() < std::filesystem::file_size(level.file()) + 512);
    CHECK(stored_bytes[shuffled] <= level.geometry().total_bytes());
  }
  CHECK(stored_bytes[1] * 3 < stored_bytes[0] * 2);
}

TEST_CASE("CodecTime_GrowsByEncodingAndDecoding_AndByNothingElse") {
  std::uint64_t last = codec_nanoseconds();
  const auto passed = [&last] {
    const std::uint64_t before = std::exchange(last, codec_nanoseconds());
    return last - before;
  };
  const auto use = [&](const BackendUnderTest& subject) {
    LevelUnderTest level(subject, {64, {}, 6, 12, 1 << 16});
    Backend& backend = level.open();
    auto bytes = make_content(level.geometry().total_bytes(), Content::kSmooth, 1);
    passed();
    backend.write({0, level.geometry().block_count()}, bytes);
    const std::uint64_t encoding = passed();
    backend.sync(true);
    CHECK(passed() == 0);
    backend.read({0, level.geometry().block_count()}, bytes);
    const std::uint64_t decoding = passed();
    return std::pair(encoding > 0, decoding > 0);
  };
  CHECK(use(compressed("shuffle,zstd:1")) == std::pair(true, true));
  CHECK(use({"pread", default_backends().find("pread"), "none"}) == std::pair(false, false));
}

TEST_CASE("CompressedBackend_RewrittenInOneSession_KeepsTheOpenedVersionWhole") {
  const auto subject = compressed("shuffle,zstd:1");
  LevelUnderTest level(subject);
  const LevelGeometry& geometry = level.geometry();
  const BlockRange all{0, geometry.block_count()};
  const auto first = make_content(geometry.total_bytes(), Content::kSmooth, 1);
  level.open().write(all, first);
  level.close();
  const BlockTable committed = level.table();

  std::uint64_t stored_bytes = 0;
  Backend& writer = level.open(OpenMode::kReadWrite);
  for (std::uint32_t round = 0; round < 6; ++round) {
    for (std::uint64_t block = 0; block < geometry.block_count(); ++block)
      writer.write({block, 1}, make_content(geometry.block_bytes(block), Content::kRandom, round));
    if (round == 0) stored_bytes = writer.stored_bytes();
  }
  CHECK(writer.stored_bytes() <= stored_bytes + 2 * geometry.max_block_bytes());
  level.close();

  // The process died here: the table that was last committed still finds its blocks.
  level.table() = committed;
  Backend& reopened = level.open(OpenMode::kReadWrite);
  CHECK(read_blocks(reopened, geometry, all) == first);
  // And what the dead session took is free again.
  const auto second = make_content(geometry.total_bytes(), Content::kRandom, 50);
  reopened.write(all, second);
  CHECK(read_blocks(reopened, geometry, all) == second);
  CHECK(reopened.stored_bytes() <= stored_bytes + geometry.max_block_bytes());
}

TEST_CASE("CompressedOpen_EncodedEntryLargerThanAnyEncodedBlock_IsRefused") {
  const auto subject = compressed("lz4");
  LevelUnderTest level(subject);
  level.open().write({0, 1}, make_content(level.geometry().block_bytes(0), Content::kRandom, 1));
  level.close();
  REQUIRE(level.table()[0].encoding == BlockEncoding::kRaw);
  level.table().entries()[0].encoding = BlockEncoding::kEncoded;
  CHECK_THROWS_AS(level.open(OpenMode::kRead), Error);
}

TEST_CASE("CompressedRead_BlockOfAnotherCodec_IsCorruptionThatNamesTheBlock") {
  const auto writer = compressed("lz4");
  LevelUnderTest level(writer);
  const std::uint64_t bytes = level.geometry().block_bytes(0);
  level.open().write({0, 1}, make_content(bytes, Content::kZeros, 1));
  level.close();
  REQUIRE(level.table()[0].encoding == BlockEncoding::kEncoded);
  const auto volume = writer.entry.open({});
  const auto reader = volume->open_level({level.directory(),
                                          level.name(),
                                          OpenMode::kRead,
                                          level.geometry(),
                                          level.table(),
                                          {},
                                          "zstd"});
  try {
    read_blocks(*reader, level.geometry(), {0, 1});
    FAIL("expected an error");
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::kCorruption);
    CHECK_THAT(error.what(), Catch::Contains(level.file().native() + ": block 0 at byte 0: "));
  }
}

}  // namespace plait::test
