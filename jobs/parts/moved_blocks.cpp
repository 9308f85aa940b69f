#include "parts/moved_blocks.h"

#include <algorithm>
#include <cstddef>

#include "plait/error.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

std::vector<std::byte> read_stored(const File& file, std::uint64_t offset, std::uint32_t bytes) {
  std::vector<std::byte> block(bytes);
  file.read_at(offset, block);
  return block;
}

}  // namespace

bool add_blocks(std::span<const BlockEntry> of_store, std::span<const BlockEntry> of_part,
                std::vector<MovedBlock>& blocks) {
  if (of_store.size() != of_part.size()) return false;
  for (std::size_t at = 0; at < of_store.size(); ++at) {
    const BlockEntry &store = of_store[at], &part = of_part[at];
    if (store.stored_bytes != part.stored_bytes || store.encoding != part.encoding ||
        store.checksum != part.checksum)
      return false;
    if (store.stored_bytes > 0) blocks.push_back({store.offset, part.offset, store.stored_bytes});
  }
  return true;
}

bool are_moved(std::span<const MovedBlock> blocks) {
  return std::ranges::any_of(
      blocks, [](const MovedBlock& block) { return block.in_store != block.in_part; });
}

bool have_same_blocks(const Directory& store, const Directory& part, const std::string& name,
                      std::span<const MovedBlock> blocks) {
  const File made(part, name, OpenMode::kRead);
  try {
    const File there(store, name, OpenMode::kRead);
    return std::ranges::all_of(blocks, [&](const MovedBlock& block) {
      return read_stored(there, block.in_store, block.bytes) ==
             read_stored(made, block.in_part, block.bytes);
    });
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kIo && error.code() != ErrorCode::kCorruption &&
        error.code() != ErrorCode::kNotFound)
      throw;
    return false;
  }
}

void write_moved(const Directory& part, const std::string& name, std::span<const MovedBlock> blocks,
                 const Directory& to) {
  const File made(part, name, OpenMode::kRead);
  File file(to, name, OpenMode::kCreate);
  for (const MovedBlock& block : blocks)
    file.write_at(block.in_store, read_stored(made, block.in_part, block.bytes));
  file.sync();
  file.close();
}

PLAIT_END_NAMESPACE
