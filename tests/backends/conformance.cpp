#include "backends/conformance.h"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <thread>

#include "plait/error.h"

namespace plait::test {
namespace {

using Bytes = std::vector<std::byte>;

/// The code of the Error that `call` throws; kCancelled, which no backend throws, for none.
template <class Call>
ErrorCode error_of(Call&& call) {
  try {
    call();
  } catch (const Error& error) {
    INFO(error.what());
    CHECK(std::string_view(error.what()).find('\n') == std::string_view::npos);
    return error.code();
  }
  return ErrorCode::kCancelled;
}

Bytes write_all(Backend& backend, const LevelGeometry& geometry, Content content,
                std::uint32_t seed = 1) {
  Bytes bytes = make_content(geometry.total_bytes(), content, seed);
  backend.write({0, geometry.block_count()}, bytes);
  return bytes;
}

Bytes read_all(Backend& backend, const LevelGeometry& geometry) {
  return read_blocks(backend, geometry, {0, geometry.block_count()});
}

Bytes part(const Bytes& bytes, const LevelGeometry& geometry, std::uint64_t block) {
  const auto first = bytes.begin() + static_cast<std::ptrdiff_t>(geometry.block_offset(block));
  return {first, first + static_cast<std::ptrdiff_t>(geometry.block_bytes(block))};
}

}  // namespace

TEST_CASE("Backend_WhatItIs_AgreesWithItsEntry") {
  for (const auto& subject : backends_under_test()) {
    INFO(subject.label);
    LevelUnderTest level(subject);
    Backend& backend = level.open();
    const BackendTraits& traits = subject.entry.traits;
    CHECK_FALSE(subject.entry.summary.empty());
    CHECK(traits.in_memory != traits.durable);
    CHECK((backend.address(0) != nullptr) == traits.in_memory);
    if (!traits.durable) continue;
    CHECK(std::filesystem::exists(level.file()));
    const Bytes content = write_all(backend, level.geometry(), Content::kSmooth);
    const std::vector<BlockEntry> before(level.table().entries().begin(),
                                         level.table().entries().end());
    write_all(backend, level.geometry(), Content::kSmooth, 2);
    for (std::uint64_t block = 0; block < before.size(); ++block)
      CHECK((level.table()[block].offset == before[block].offset) == traits.overwrites_in_place);
    if (!traits.compressed) CHECK(level.table()[0].stored_bytes == level.geometry().block_bytes(0));
    CHECK((level.open(OpenMode::kRead).address(0) != nullptr) == traits.maps_for_reading);
  }
}

TEST_CASE("BackendRead_NeverWritten_IsZeros") {
  for (const auto& subject : backends_under_test()) {
    INFO(subject.label);
    LevelUnderTest level(subject);
    Backend& backend = level.open();
    REQUIRE(level.geometry().block_count() > 3);
    CHECK(read_all(backend, level.geometry()) == Bytes(level.geometry().total_bytes()));

    // Next to blocks that were written, too.
    const std::uint64_t bytes = level.geometry().block_bytes(1);
    const Bytes content = make_content(bytes, Content::kRandom, 5);
    backend.write({1, 1}, content);
    const Bytes all = read_all(backend, level.geometry());
    CHECK(part(all, level.geometry(), 0) == Bytes(level.geometry().block_bytes(0)));
    CHECK(part(all, level.geometry(), 1) == content);
    CHECK(part(all, level.geometry(), 2) == Bytes(level.geometry().block_bytes(2)));
  }
}

TEST_CASE("BackendRead_ShapesOfLevels_GivesWhatWasWritten") {
  std::vector<LevelShape> shapes;
  for (int level = 1; level <= 8; ++level)
    for (const std::size_t record_bytes : {4u, 12u, 24u})
      shapes.push_back({level < 5 ? 37u : 3u, {}, level, record_bytes, 4096});
  shapes.push_back({37, {0, 1, 5, 20, 36}, 4, 12, 4096});       // borders among the others
  shapes.push_back({9, {0, 1, 2, 3, 4, 5, 6, 7, 8}, 3, 4, 0});  // nothing but borders
  shapes.push_back({1, {}, 1, 1, 1 << 20});                     // one record
  shapes.push_back({1000, {}, 2, 12, 1 << 20});                 // one block, partly full

  for (const auto& subject : backends_under_test()) {
    for (const LevelShape& shape : shapes) {
      INFO(subject.label << " level " << shape.level << " edges " << shape.edge_count
                         << " record bytes " << shape.record_bytes);
      LevelUnderTest level(subject, shape);
      Backend& backend = level.open();
      const LevelGeometry& geometry = level.geometry();
      const Bytes content = make_content(geometry.total_bytes(), Content::kSmooth, 7);
      for (std::uint64_t block = geometry.block_count(); block-- > 0;)
        backend.write({block, 1}, part(content, geometry, block));
      CHECK(read_all(backend, geometry) == content);
      const Bytes other = write_all(backend, geometry, Content::kRandom);
      for (std::uint64_t block = 0; block < geometry.block_count(); ++block)
        CHECK(read_blocks(backend, geometry, {block, 1}) == part(other, geometry, block));
    }
  }
}

TEST_CASE("BackendWrite_OtherContentOverTheOld_IsReadBack") {
  constexpr Content kContents[] = {Content::kRandom, Content::kZeros, Content::kSmooth,
                                   Content::kRandom, Content::kSmooth};
  for (const auto& subject : backends_under_test()) {
    INFO(subject.label);
    LevelUnderTest level(subject);
    Backend& backend = level.open();
    Bytes all = write_all(backend, level.geometry(), Content::kSmooth);
    std::uint32_t seed = 100;
    for (const Content content : kContents) {
      for (std::uint64_t block = seed % 2; block < level.geometry().block_count(); block += 2) {
        const std::uint64_t bytes = level.geometry().block_bytes(block);
        const Bytes fresh = make_content(bytes, content, seed + static_cast<std::uint32_t>(block));
        backend.write({block, 1}, fresh);
        std::ranges::copy(
            fresh, all.begin() + static_cast<std::ptrdiff_t>(level.geometry().block_offset(block)));
      }
      ++seed;
      CHECK(read_all(backend, level.geometry()) == all);
    }
    if (!subject.entry.traits.durable) continue;
    CHECK(read_all(level.open(OpenMode::kRead), level.geometry()) == all);
  }
}

TEST_CASE("BackendAddress_LevelInMemory_IsStableAndCountsWhatIsStored") {
  for (const auto& subject : backends_under_test()) {
    if (!subject.entry.traits.in_memory) continue;
    INFO(subject.label);
    LevelUnderTest level(subject);
    Backend& backend = level.open();
    const LevelGeometry& geometry = level.geometry();
    std::vector<std::byte*> addresses;
    for (std::uint64_t block = 0; block < geometry.block_count(); ++block)
      addresses.push_back(backend.address(block));
    const Bytes content = write_all(backend, geometry, Content::kRandom);
    backend.advise({0, geometry.block_count()}, Advice::kDontNeed);
    backend.sync(true);
    for (std::uint64_t block = 0; block < geometry.block_count(); ++block) {
      REQUIRE(backend.address(block) == addresses[block]);
      CHECK(std::ranges::equal(part(content, geometry, block),
                               std::span(addresses[block], geometry.block_bytes(block))));
    }
    // Stored to by hand and written in place, as the pager does: read() sees it.
    const std::span<std::byte> second(addresses[2], geometry.block_bytes(2));
    std::ranges::fill(second, std::byte{7});
    backend.write({2, 1}, second);
    CHECK(read_blocks(backend, geometry, {2, 1}) == Bytes(geometry.block_bytes(2), std::byte{7}));
  }
}

TEST_CASE("BackendAddress_MappedLevel_IsStableAndVerifiedWhereItLies") {
  for (const auto& subject : backends_under_test()) {
    if (!subject.entry.traits.maps_for_reading) continue;
    INFO(subject.label);
    LevelUnderTest level(subject);
    const LevelGeometry& geometry = level.geometry();
    const Bytes content = write_all(level.open(), geometry, Content::kRandom);
    Backend& backend = level.open(OpenMode::kRead);
    for (std::uint64_t block = 0; block < geometry.block_count(); ++block) {
      std::byte* const address = backend.address(block);
      const std::span<std::byte> bytes(address, geometry.block_bytes(block));
      backend.read({block, 1}, bytes);
      CHECK(std::ranges::equal(part(content, geometry, block), bytes));
      backend.advise({block, 1}, Advice::kDontNeed);
      CHECK(backend.address(block) == address);
      CHECK(std::ranges::equal(part(content, geometry, block), bytes));
    }
    File(level.file(), OpenMode::kReadWrite)
        .write_at(geometry.block_offset(2),
                  Bytes(1, content[geometry.block_offset(2)] ^ std::byte{8}));
    const std::span<std::byte> second(backend.address(2), geometry.block_bytes(2));
    CHECK(error_of([&] { backend.read({2, 1}, second); }) == ErrorCode::kCorruption);
    CHECK(error_of([&] { read_blocks(backend, geometry, {2, 1}); }) == ErrorCode::kCorruption);
  }
}

TEST_CASE("BackendAdvise_AnyAdviceAnywhere_ChangesNoResult") {
  for (const auto& subject : backends_under_test()) {
    INFO(subject.label);
    LevelUnderTest level(subject);
    Backend& backend = level.open();
    const std::uint64_t blocks = level.geometry().block_count();
    Bytes content = write_all(backend, level.geometry(), Content::kSmooth);
    for (const Advice advice :
         {Advice::kWillNeed, Advice::kDontNeed, Advice::kSequential, Advice::kRandom}) {
      for (const BlockRange range :
           {BlockRange{0, blocks}, BlockRange{1, 1}, BlockRange{blocks - 1, 1}, BlockRange{0, 0},
            BlockRange{blocks, 5}, BlockRange{blocks - 1, ~std::uint64_t{0}}})
        backend.advise(range, advice);
      CHECK(read_all(backend, level.geometry()) == content);
      content = write_all(backend, level.geometry(), Content::kRandom,
                          static_cast<std::uint32_t>(advice) + 10);
    }
    CHECK(read_all(backend, level.geometry()) == content);
  }
}

TEST_CASE("BackendCall_BlocksThatTheLevelLacks_IsRefused") {
  for (const auto& subject : backends_under_test()) {
    INFO(subject.label);
    LevelUnderTest level(subject);
    Backend& backend = level.open();
    const std::uint64_t blocks = level.geometry().block_count();
    Bytes bytes(level.geometry().max_block_bytes());
    for (const BlockRange range : {BlockRange{blocks, 1}, BlockRange{blocks - 1, 2},
                                   BlockRange{1, ~std::uint64_t{0}}, BlockRange{0, 2}}) {
      CHECK(error_of([&] { backend.read(range, bytes); }) == ErrorCode::kInvalidArgument);
      CHECK(error_of([&] { backend.write(range, bytes); }) == ErrorCode::kInvalidArgument);
    }
    CHECK(read_all(backend, level.geometry()) == Bytes(level.geometry().total_bytes()));
  }
}

TEST_CASE("BackendOpen_TableOfAnotherSize_IsRefused") {
  for (const auto& subject : backends_under_test()) {
    INFO(subject.label);
    LevelUnderTest level(subject);
    level.table() = BlockTable({}, 2, 3, level.geometry().block_count() + 1);
    CHECK(error_of([&] { level.open(); }) == ErrorCode::kInvalidArgument);
    CHECK_FALSE(std::filesystem::exists(level.file()));
  }
}

TEST_CASE("Backend_TwoThreadsOnDifferentBlocks_DoNotMix") {
  for (const auto& subject : backends_under_test()) {
    INFO(subject.label);
    LevelUnderTest level(subject, {64, {}, 4, 12, 4096});
    Backend& backend = level.open();
    const LevelGeometry& geometry = level.geometry();
    std::atomic<int> mismatches = 0;
    const auto work = [&](std::uint64_t parity) {
      try {
        for (std::uint32_t round = 0; round < 4; ++round) {
          for (std::uint64_t block = parity; block < geometry.block_count(); block += 2) {
            const auto content = (block / 2 + round) % 2 == 0 ? Content::kRandom : Content::kSmooth;
            const Bytes bytes = make_content(geometry.block_bytes(block), content,
                                             round * 1000 + static_cast<std::uint32_t>(block));
            backend.write({block, 1}, bytes);
            backend.stored_bytes();
            if (read_blocks(backend, geometry, {block, 1}) != bytes) ++mismatches;
          }
        }
      } catch (const Error&) {
        ++mismatches;
      }
    };
    std::thread other(work, 1);
    work(0);
    other.join();
    CHECK(mismatches == 0);
  }
}

}  // namespace plait::test
