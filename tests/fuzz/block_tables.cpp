// A file of block tables, read for levels of any shape. If the reader accepts it, the entries are
// exactly those in the bytes, and a backend can use each entry.
//
// Input: number of levels, then for each edges, border edges, level, record bytes and block size;
// the rest is the file.
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <vector>

#include "input_bytes.h"
#include "oracle.h"
#include "store/block_tables_file.h"

using namespace plait;
using namespace plait::fuzz;

namespace {

constexpr std::size_t kHeaderBytes = 16;

struct Level {
  std::vector<EdgeId> border_edges;
  LevelGeometry geometry;
};

Level take_level(InputBytes& input) {
  const std::uint64_t edges = input.take<std::uint16_t>();
  Level level;
  level.border_edges.resize(std::min<std::uint64_t>(input.take<std::uint8_t>(), edges));
  std::iota(level.border_edges.begin(), level.border_edges.end(), EdgeId{0});
  const int number = 1 + static_cast<int>(input.take_below(20));
  const std::size_t record_bytes = 1 + input.take_below(255) * 8;
  const std::uint64_t block_bytes = std::uint64_t{4096} << input.take_below(19);
  level.geometry = LevelGeometry(edges, level.border_edges, BaseRelativeLevel(number), record_bytes,
                                 block_bytes);
  return level;
}

bool is_usable(const BlockEntry& entry, std::uint64_t raw_bytes) {
  switch (static_cast<std::uint32_t>(entry.encoding)) {
    case 0:
      return entry.offset == 0 && entry.stored_bytes == 0 && entry.checksum == 0;
    case 1:
      return entry.stored_bytes == raw_bytes && entry.offset + raw_bytes > entry.offset;
    case 2:
      return entry.stored_bytes > 0 && entry.stored_bytes < raw_bytes &&
             entry.offset + entry.stored_bytes > entry.offset;
    default:
      return false;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  InputBytes input(data, size);
  std::vector<Level> levels(input.take_below(4));
  // LevelGeometry refuses a level too large for any file, before its table is read.
  if (!accepts({ErrorCode::kInvalidArgument}, [&] {
        for (Level& level : levels) level = take_level(input);
      }))
    return 0;

  ExactBytes copy(input.rest());
  const std::span<const std::byte> file = copy.span();
  accepts({ErrorCode::kCorruption}, [&] {
    BlockTablesReader reader(file, "tables");
    std::vector<BlockEntry> all;
    for (const Level& level : levels) {
      const std::vector<BlockEntry> entries = reader.next_level(level.geometry);
      require(entries.size() == level.geometry.block_count());
      for (std::size_t block = 0; block < entries.size(); ++block)
        require(is_usable(entries[block], level.geometry.block_bytes(block)));
      all.insert(all.end(), entries.begin(), entries.end());
    }
    reader.finish();
    require(std::ranges::equal(std::as_bytes(std::span(all)), file.subspan(kHeaderBytes)));
    const std::vector<std::byte> header = encode_tables({});
    require(std::ranges::equal(std::span(header).first(12), file.first(12)));  // the rest: reserved
  });
  return 0;
}
