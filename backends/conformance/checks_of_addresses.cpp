// Checks of Backend::address(): levels in memory, and levels that are mapped for reading.
#include <algorithm>

#include "conformance/suite.h"

namespace plait::conformance {

void check_address_in_memory(const Subject& subject, CheckLog& log) {
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
    log.require(addresses[block] != nullptr && backend.address(block) == addresses[block],
                "a block has one address, also after write(), advise() and sync()");
    log.expect(std::ranges::equal(part(content, geometry, block),
                                  std::span(addresses[block], geometry.block_bytes(block))),
               "the bytes at a block's address are those that were written");
  }
  // As the pager does: it stores to the address and then calls write() with it.
  const std::span<std::byte> second(addresses[2], geometry.block_bytes(2));
  std::ranges::fill(second, std::byte{7});
  backend.write({2, 1}, second);
  log.expect(read_blocks(backend, geometry, {2, 1}) == Bytes(geometry.block_bytes(2), std::byte{7}),
             "read() gives what was stored at the address before write() got this address");
}

void check_address_mapped(const Subject& subject, CheckLog& log) {
  LevelUnderTest level(subject);
  const LevelGeometry& geometry = level.geometry();
  const Bytes content = write_all(level.open(), geometry, Content::kRandom);
  Backend& backend = level.open(OpenMode::kRead);
  for (std::uint64_t block = 0; block < geometry.block_count(); ++block) {
    std::byte* const address = backend.address(block);
    log.require(address != nullptr, "each block of a mapped level has an address");
    const std::span<std::byte> bytes(address, geometry.block_bytes(block));
    backend.read({block, 1}, bytes);
    log.expect(std::ranges::equal(part(content, geometry, block), bytes),
               "read() with a block's own address keeps its bytes there");
    backend.advise({block, 1}, Advice::kDontNeed);
    log.expect(backend.address(block) == address, "advice does not move a block");
    log.expect(std::ranges::equal(part(content, geometry, block), bytes),
               "advice does not change the bytes at a block's address");
  }
  File(level.file(), OpenMode::kReadWrite)
      .write_at(geometry.block_offset(2),
                Bytes(1, content[geometry.block_offset(2)] ^ std::byte{8}));
  const std::span<std::byte> second(backend.address(2), geometry.block_bytes(2));
  log.expect(error_of(log,
                      [&] {
                        backend.read({2, 1}, second);
                      }) == ErrorCode::kCorruption,
             "read() with a damaged block's own address fails (kCorruption)");
  log.expect(error_of(log,
                      [&] {
                        read_blocks(backend, geometry, {2, 1});
                      }) == ErrorCode::kCorruption,
             "read() of a damaged block fails (kCorruption)");
}

}  // namespace plait::conformance
