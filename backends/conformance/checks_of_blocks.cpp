// Checks of what holds for every backend: reading, writing, refusing, advice, threads.
#include <algorithm>
#include <array>
#include <atomic>
#include <exception>
#include <filesystem>
#include <thread>

#include "conformance/suite.h"

namespace plait::conformance {

void check_entry(const Subject& subject, CheckLog& log) {
  LevelUnderTest level(subject);
  Backend& backend = level.open();
  const BackendTraits& traits = subject.entry.traits;
  log.expect(!subject.entry.summary.empty(), "the entry has a summary");
  log.expect(!(traits.in_memory && traits.durable),
             "a level is a file (durable) or memory (in_memory), not both");
  log.expect((backend.address(0) != nullptr) == traits.in_memory,
             "address() of a level that is written is not null if, and only if, the level is "
             "in memory");
  if (!traits.durable) return;
  log.expect(std::filesystem::exists(level.file()),
             "a durable level is a file with the name of the level");
  const Bytes content = write_all(backend, level.geometry(), Content::kSmooth);
  const std::vector<BlockEntry> before(level.table().entries().begin(),
                                       level.table().entries().end());
  write_all(backend, level.geometry(), Content::kSmooth, 2);
  for (std::uint64_t block = 0; block < before.size(); ++block)
    log.expect(
        (level.table()[block].offset == before[block].offset) == traits.overwrites_in_place,
        "a block that is written again keeps its offset if, and only if, the backend overwrites in "
        "place");
  if (!traits.compressed)
    log.expect(level.table()[0].stored_bytes == level.geometry().block_bytes(0),
               "without compression, a block takes its raw size");
  log.expect(
      (level.open(OpenMode::kRead).address(0) != nullptr) == traits.maps_for_reading,
      "address() of a level that is only read is not null if, and only if, the backend maps it");
}

void check_never_written(const Subject& subject, CheckLog& log) {
  LevelUnderTest level(subject);
  Backend& backend = level.open();
  const LevelGeometry& geometry = level.geometry();
  log.expect(read_all(backend, geometry) == Bytes(geometry.total_bytes()),
             "a new level reads as zeros");

  log.at("one block was written");
  const Bytes content = make_content(geometry.block_bytes(1), Content::kRandom, 5);
  backend.write({1, 1}, content);
  const Bytes all = read_all(backend, geometry);
  log.expect(part(all, geometry, 0) == Bytes(geometry.block_bytes(0)),
             "the block before it reads as zeros");
  log.expect(part(all, geometry, 1) == content, "the block reads as it was written");
  log.expect(part(all, geometry, 2) == Bytes(geometry.block_bytes(2)),
             "the block after it reads as zeros");
}

void check_shapes(const Subject& subject, CheckLog& log) {
  std::vector<LevelShape> shapes;
  for (int level = 1; level <= 8; ++level)
    for (const std::size_t record_bytes : {4u, 12u, 24u})
      shapes.push_back({level < 5 ? 37u : 3u, {}, level, record_bytes, 4096});
  shapes.push_back({37, {0, 1, 5, 20, 36}, 4, 12, 4096});       // borders among the others
  shapes.push_back({9, {0, 1, 2, 3, 4, 5, 6, 7, 8}, 3, 4, 0});  // nothing but borders
  shapes.push_back({1, {}, 1, 1, 1 << 20});                     // one record
  shapes.push_back({1000, {}, 2, 12, 1 << 20});                 // one block, partly full

  for (const LevelShape& shape : shapes) {
    log.at("level " + std::to_string(shape.level) + ", " + std::to_string(shape.edge_count) +
           " edges, records of " + std::to_string(shape.record_bytes) + " bytes");
    LevelUnderTest level(subject, shape);
    Backend& backend = level.open();
    const LevelGeometry& geometry = level.geometry();
    const Bytes content = make_content(geometry.total_bytes(), Content::kSmooth, 7);
    for (std::uint64_t block = geometry.block_count(); block-- > 0;)
      backend.write({block, 1}, part(content, geometry, block));
    log.expect(read_all(backend, geometry) == content,
               "all blocks in one read are as they were written, one by one");
    const Bytes other = write_all(backend, geometry, Content::kRandom);
    for (std::uint64_t block = 0; block < geometry.block_count(); ++block)
      log.expect(read_blocks(backend, geometry, {block, 1}) == part(other, geometry, block),
                 "each block reads as it was written, all of them in one call");
  }
}

void check_overwriting(const Subject& subject, CheckLog& log) {
  constexpr Content kContents[] = {Content::kRandom, Content::kZeros, Content::kSmooth,
                                   Content::kRandom, Content::kSmooth};
  LevelUnderTest level(subject);
  Backend& backend = level.open();
  const LevelGeometry& geometry = level.geometry();
  Bytes all = write_all(backend, geometry, Content::kSmooth);
  std::uint32_t seed = 100;
  for (const Content content : kContents) {
    log.at(to_string(content));
    for (std::uint64_t block = seed % 2; block < geometry.block_count(); block += 2) {
      const Bytes fresh = make_content(geometry.block_bytes(block), content,
                                       seed + static_cast<std::uint32_t>(block));
      backend.write({block, 1}, fresh);
      std::ranges::copy(fresh,
                        all.begin() + static_cast<std::ptrdiff_t>(geometry.block_offset(block)));
    }
    ++seed;
    log.expect(read_all(backend, geometry) == all,
               "blocks that were written again have the new content, all others the old");
  }
  if (!subject.entry.traits.durable) return;
  log.at("opened again");
  log.expect(read_all(level.open(OpenMode::kRead), geometry) == all,
             "blocks that were written again have the new content, all others the old");
}

void check_bounds(const Subject& subject, CheckLog& log) {
  LevelUnderTest level(subject);
  Backend& backend = level.open();
  const std::uint64_t blocks = level.geometry().block_count();
  Bytes bytes(level.geometry().max_block_bytes());
  for (const BlockRange range : {BlockRange{blocks, 1}, BlockRange{blocks - 1, 2},
                                 BlockRange{1, ~std::uint64_t{0}}, BlockRange{0, 2}}) {
    log.at(std::to_string(range.count) + " blocks from " + std::to_string(range.first) + " of " +
           std::to_string(blocks) + ", in the memory of one");
    log.expect(error_of(log, [&] { backend.read(range, bytes); }) == ErrorCode::kInvalidArgument,
               "read() refuses (kInvalidArgument)");
    log.expect(error_of(log, [&] { backend.write(range, bytes); }) == ErrorCode::kInvalidArgument,
               "write() refuses (kInvalidArgument)");
  }
  log.at("");
  log.expect(read_all(backend, level.geometry()) == Bytes(level.geometry().total_bytes()),
             "a refused write changes nothing");
}

void check_table_size(const Subject& subject, CheckLog& log) {
  LevelUnderTest level(subject);
  level.table() = BlockTable({}, 2, 3, level.geometry().block_count() + 1);
  log.expect(error_of(log, [&] { level.open(); }) == ErrorCode::kInvalidArgument,
             "open_level() refuses a table with another number of blocks (kInvalidArgument)");
  log.expect(!std::filesystem::exists(level.file()), "a refused open_level() makes no file");
}

void check_advice(const Subject& subject, CheckLog& log) {
  LevelUnderTest level(subject);
  Backend& backend = level.open();
  const std::uint64_t blocks = level.geometry().block_count();
  Bytes content = write_all(backend, level.geometry(), Content::kSmooth);
  for (const Advice advice : {Advice::kDontNeed, Advice::kSequential, Advice::kOverwrite}) {
    for (const BlockRange range :
         {BlockRange{0, blocks}, BlockRange{1, 1}, BlockRange{blocks - 1, 1}, BlockRange{0, 0},
          BlockRange{blocks, 5}, BlockRange{blocks - 1, ~std::uint64_t{0}}})
      backend.advise(range, advice);
    log.expect(read_all(backend, level.geometry()) == content,
               "after advice, blocks read as they were written");
    content = write_all(backend, level.geometry(), Content::kRandom,
                        static_cast<std::uint32_t>(advice) + 10);
  }
  log.expect(read_all(backend, level.geometry()) == content,
             "after advice, blocks read as they were written");
}

void check_threads(const Subject& subject, CheckLog& log) {
  LevelUnderTest level(subject, {64, {}, 4, 12, 4096});
  Backend& backend = level.open();
  const LevelGeometry& geometry = level.geometry();
  std::atomic<int> mismatches = 0, errors = 0;
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
    } catch (const std::exception&) {
      ++errors;
    }
  };
  std::thread other(work, 1);
  work(0);
  other.join();
  log.expect(errors == 0, "no call of two threads on different blocks throws");
  log.expect(mismatches == 0, "a thread reads what it wrote while another writes elsewhere");
}

void check_context(const Subject& subject, CheckLog& log) {
  LevelUnderTest level(subject);
  const Backend& backend = level.open();
  for (std::uint64_t block = 0; block < level.geometry().block_count(); ++block) {
    std::array<ContextBlock, kMostContextBlocks> first, second;
    const std::size_t count = backend.context(block, first);
    log.require(count <= kMostContextBlocks, "a block needs no more others than a transfer takes");
    log.require(count == backend.context(block, second),
                "the number of blocks that a block needs stays the same");
    for (std::size_t at = 0; at < count; ++at) {
      log.expect(first[at].attribute == second[at].attribute &&
                     first[at].level == second[at].level && first[at].block == second[at].block,
                 "the blocks that a block needs stay the same");
      log.expect(first[at].attribute < level.table().attribute() ||
                     (first[at].attribute == level.table().attribute() &&
                      first[at].level < level.table().level()),
                 "the blocks that a block needs are of an earlier attribute, or coarser");
    }
  }
}

}  // namespace plait::conformance
