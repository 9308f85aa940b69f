// Block tables, read for levels of any shape. If the reader accepts them, the entries are exactly
// those in the bytes, and a backend can use each entry.
//
// Input: number of levels, then for each edges, border edges, level, record bytes and block size;
// the rest is the tables.
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <vector>

#include "format/version_file.h"
#include "input_bytes.h"
#include "oracle.h"

using namespace plait;
using namespace plait::fuzz;

namespace {

LevelGeometry take_level(InputBytes& input) {
  const std::uint64_t edges = input.take<std::uint16_t>();
  std::vector<EdgeId> border_edges(std::min<std::uint64_t>(input.take<std::uint8_t>(), edges));
  std::iota(border_edges.begin(), border_edges.end(), EdgeId{0});
  const int number = 1 + static_cast<int>(input.take_below(20));
  const std::size_t record_bytes = 1 + input.take_below(255) * 8;
  const std::uint64_t block_bytes = std::uint64_t{4096} << input.take_below(19);
  return LevelGeometry(SlotShapes(edges, EdgeSet(border_edges)), BaseRelativeLevel(number),
                       record_bytes, block_bytes);
}

constexpr std::uint64_t kLogBytes = 1 << 20;

bool is_usable(const BlockEntry& entry, std::uint64_t raw_bytes) {
  if (entry.file == kLogFile)
    return entry.encoding == BlockEncoding::kRaw && entry.stored_bytes == raw_bytes &&
           entry.offset % 4096 == 0 && entry.offset + raw_bytes <= kLogBytes;
  if (entry.file != kLevelFile) return false;
  switch (static_cast<std::uint32_t>(entry.encoding)) {
    case 0:
      return entry.offset == 0 && entry.stored_bytes == 0 && entry.checksum == 0;
    case 1:
      return entry.stored_bytes == raw_bytes && entry.offset + raw_bytes > entry.offset;
    case 2:
      return entry.stored_bytes > 0 && entry.stored_bytes < raw_bytes &&
             entry.offset + entry.stored_bytes > entry.offset;
    case 3:
      return entry.offset == 0 && entry.stored_bytes == 0;
    default:
      return false;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  InputBytes input(data, size);
  std::vector<LevelGeometry> levels(input.take_below(4));
  // LevelGeometry refuses a level too large for any file, before its table is read.
  if (!accepts({ErrorCode::kInvalidArgument}, [&] {
        for (LevelGeometry& level : levels) level = take_level(input);
      }))
    return 0;

  ExactBytes copy(input.rest());
  const std::span<const std::byte> file = copy.span();
  accepts({ErrorCode::kCorruption}, [&] {
    BlockTablesReader reader(file, "version");
    std::vector<BlockEntry> all;
    for (const LevelGeometry& level : levels) {
      const std::vector<BlockEntry> entries = reader.next_level(level, kLogBytes);
      require(entries.size() == level.block_count());
      for (std::size_t block = 0; block < entries.size(); ++block)
        require(is_usable(entries[block], level.block_bytes(block)));
      all.insert(all.end(), entries.begin(), entries.end());
    }
    reader.finish();
    require(std::ranges::equal(std::as_bytes(std::span(all)), file));
  });
  return 0;
}
