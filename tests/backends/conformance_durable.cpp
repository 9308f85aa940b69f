// The part of the suite for levels that are files: reopening, damage, refusals.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cerrno>
#include <filesystem>
#include <utility>

#include "backends/conformance.h"
#include "durability/faults.h"
#include "plait/error.h"

namespace plait::test {
namespace {

using Bytes = std::vector<std::byte>;

/// Opens and reads all; the code of the Error on the way, or kCancelled for none.
ErrorCode error_of_reading(LevelUnderTest& level, OpenMode mode = OpenMode::kRead) {
  try {
    read_blocks(level.open(mode), level.geometry(), {0, level.geometry().block_count()});
  } catch (const Error& error) {
    CHECK(std::string_view(error.what()).find(level.file().native()) != std::string_view::npos);
    return error.code();
  }
  return ErrorCode::kCancelled;
}

Bytes write_and_close(LevelUnderTest& level, Content content) {
  Bytes bytes = make_content(level.geometry().total_bytes(), content, 3);
  Backend& backend = level.open();
  backend.write({0, level.geometry().block_count()}, bytes);
  backend.sync(true);
  level.close();
  return bytes;
}

Bytes stored(const LevelUnderTest& level, const BlockEntry& entry) {
  Bytes bytes(entry.stored_bytes);
  File(level.file(), OpenMode::kRead).read_at(entry.offset, bytes);
  return bytes;
}

void overwrite(const LevelUnderTest& level, std::uint64_t offset, const Bytes& bytes) {
  File(level.file(), OpenMode::kReadWrite).write_at(offset, bytes);
}

std::vector<BackendUnderTest> durable_backends() {
  auto subjects = backends_under_test();
  std::erase_if(subjects, [](const auto& subject) { return !subject.entry.traits.durable; });
  return subjects;
}

}  // namespace

TEST_CASE("BackendOpen_AgainWithTheSameTable_HasTheSameBytes") {
  for (const auto& subject : durable_backends()) {
    for (const Content content : {Content::kZeros, Content::kSmooth, Content::kRandom}) {
      INFO(subject.label);
      LevelUnderTest level(subject, {37, {0, 3, 30}, 3, 24, 4096});
      Bytes bytes = write_and_close(level, content);
      const BlockRange all{0, level.geometry().block_count()};
      Backend& reader = level.open(OpenMode::kRead);
      CHECK(read_blocks(reader, level.geometry(), all) == bytes);
      CHECK(reader.stored_bytes() > 0);
      reader.sync(true);

      Backend& writer = level.open(OpenMode::kReadWrite);
      CHECK(read_blocks(writer, level.geometry(), all) == bytes);
      const Bytes fresh = make_content(level.geometry().block_bytes(1), Content::kRandom, 9);
      writer.write({1, 1}, fresh);
      writer.sync(true);
      std::ranges::copy(
          fresh, bytes.begin() + static_cast<std::ptrdiff_t>(level.geometry().block_offset(1)));
      CHECK(read_blocks(level.open(OpenMode::kRead), level.geometry(), all) == bytes);
    }
  }
}

TEST_CASE("BackendOpen_FileThatExistsOrNot_ObeysItsMode") {
  for (const auto& subject : durable_backends()) {
    INFO(subject.label);
    LevelUnderTest level(subject);
    CHECK(error_of_reading(level) == ErrorCode::kNotFound);
    CHECK(error_of_reading(level, OpenMode::kReadWrite) == ErrorCode::kNotFound);
    CHECK_FALSE(std::filesystem::exists(level.file()));
    write_and_close(level, Content::kSmooth);
    CHECK(error_of_reading(level, OpenMode::kCreate) != ErrorCode::kCancelled);
    CHECK(error_of_reading(level) == ErrorCode::kCancelled);
  }
}

TEST_CASE("BackendWrite_OpenedForReading_IsRefused") {
  for (const auto& subject : durable_backends()) {
    INFO(subject.label);
    LevelUnderTest level(subject);
    write_and_close(level, Content::kSmooth);
    Backend& backend = level.open(OpenMode::kRead);
    const BlockEntry before = level.table()[0];
    const Bytes bytes(level.geometry().block_bytes(0));
    try {
      backend.write({0, 1}, bytes);
      FAIL("expected an error");
    } catch (const Error& error) {
      CHECK(error.code() == ErrorCode::kBadState);
    }
    CHECK(level.table()[0].checksum == before.checksum);
    CHECK(error_of_reading(level) == ErrorCode::kCancelled);
  }
}

TEST_CASE("BackendRead_FlippedStoredBit_IsFound") {
  for (const auto& subject : durable_backends()) {
    for (const Content content : {Content::kSmooth, Content::kRandom}) {
      INFO(subject.label);
      LevelUnderTest level(subject);
      write_and_close(level, content);
      const std::uint64_t last = level.geometry().block_count() - 1;
      for (const std::uint64_t block : {std::uint64_t{0}, last}) {
        const BlockEntry& entry = level.table()[block];
        const Bytes good = stored(level, entry);
        for (const std::size_t place : {std::size_t{0}, good.size() / 2, good.size() - 1}) {
          Bytes bad = good;
          bad[place] ^= std::byte{0x10};
          overwrite(level, entry.offset, bad);
          CHECK(error_of_reading(level) == ErrorCode::kCorruption);
        }
        overwrite(level, entry.offset, good);
        CHECK(error_of_reading(level) == ErrorCode::kCancelled);
      }
    }
  }
}

TEST_CASE("BackendRead_BlocksThatSwappedPlaces_AreFound") {
  for (const auto& subject : durable_backends()) {
    INFO(subject.label);
    LevelUnderTest level(subject);
    write_and_close(level, Content::kRandom);  // stored raw everywhere, so of one size
    const BlockEntry first = level.table()[0], second = level.table()[1];
    REQUIRE(first.stored_bytes == second.stored_bytes);
    const Bytes first_bytes = stored(level, first), second_bytes = stored(level, second);
    overwrite(level, first.offset, second_bytes);
    overwrite(level, second.offset, first_bytes);
    CHECK(error_of_reading(level) == ErrorCode::kCorruption);

    // With their checksums swapped along: the checksum is bound to the block's number.
    level.table().entries()[0].checksum = second.checksum;
    level.table().entries()[1].checksum = first.checksum;
    CHECK(error_of_reading(level) == ErrorCode::kCorruption);
  }
}

TEST_CASE("BackendOpen_FileCutShort_IsFoundAtOpenOrRead") {
  for (const auto& subject : durable_backends()) {
    INFO(subject.label);
    LevelUnderTest level(subject);
    write_and_close(level, Content::kRandom);
    std::uint64_t end = 0;
    for (const BlockEntry& entry : std::as_const(level.table()).entries())
      end = std::max(end, entry.offset + entry.stored_bytes);
    for (const std::uint64_t bytes : {end - 1, end / 2, std::uint64_t{0}}) {
      std::filesystem::resize_file(level.file(), bytes);
      CHECK(error_of_reading(level) == ErrorCode::kCorruption);
      CHECK(error_of_reading(level, OpenMode::kReadWrite) == ErrorCode::kCorruption);
    }
  }
}

TEST_CASE("BackendRead_FileCutShortWhileItIsOpen_IsAnError") {
  for (const auto& subject : durable_backends()) {
    INFO(subject.label);
    LevelUnderTest level(subject);
    write_and_close(level, Content::kRandom);
    Backend& backend = level.open(OpenMode::kRead);
    std::filesystem::resize_file(level.file(), 0);
    for (std::uint64_t block = 0; block < level.geometry().block_count(); ++block) {
      CHECK_THROWS_AS(read_blocks(backend, level.geometry(), {block, 1}), Error);
      if (subject.entry.traits.maps_for_reading) CHECK_THROWS_AS(backend.address(block), Error);
    }
  }
}

// Blocks are whole pages, so that each is one write, which fails as a whole.
TEST_CASE("BackendWrite_ThatFails_LeavesTheBlockAsItWas") {
  for (const auto& subject : durable_backends()) {
    INFO(subject.label);
    LevelUnderTest level(subject, {16, {}, 5, 16, 16 << 10});
    const LevelGeometry& geometry = level.geometry();
    Backend& backend = level.open();
    const Bytes before = make_content(geometry.total_bytes(), Content::kRandom, 3),
                other = make_content(geometry.block_bytes(1), Content::kRandom, 4);
    backend.write({0, geometry.block_count()}, before);
    {
      const FailingOperations full(level.directory().path(), 0, ENOSPC,
                                   FailingOperations::From::kAllFromThere);
      CHECK_THROWS_AS(backend.write({1, 1}, other), Error);
    }
    CHECK(read_blocks(backend, geometry, {0, geometry.block_count()}) == before);
  }
}

TEST_CASE("BackendOpen_EntryThatCannotBe_IsRefused") {
  for (const auto& subject : durable_backends()) {
    INFO(subject.label);
    LevelUnderTest level(subject);
    write_and_close(level, Content::kSmooth);
    const BlockEntry good = level.table()[1];
    std::vector<BlockEntry> bad(7, good);
    bad[0].offset = ~std::uint64_t{0};
    bad[1].offset = ~std::uint64_t{0} - 511;
    bad[2].offset += 4;
    bad[3].offset = level.table()[0].offset;
    bad[4].stored_bytes = 0xffffffff;
    bad[5].stored_bytes = 0;
    bad[6].encoding = static_cast<BlockEncoding>(7);
    for (const BlockEntry& entry : bad) {
      level.table().entries()[1] = entry;
      CHECK(error_of_reading(level) == ErrorCode::kCorruption);
    }
    level.table().entries()[1] = good;
    CHECK(error_of_reading(level) == ErrorCode::kCancelled);
  }
}

}  // namespace plait::test
