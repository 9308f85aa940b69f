// Any block through any pipeline and back.
//
// Input: coding, room for the codec, then the block.
#include <algorithm>
#include <cstdint>

#include "coding.h"
#include "compressed/block_coder.h"
#include "oracle.h"

using namespace plait;
using namespace plait::fuzz;

namespace {

void check_filter(const Filter& filter, std::span<const std::byte> raw) {
  ExactBytes filtered(raw.size()), back(raw.size());
  filter.encode({}, raw, filtered.span());
  filter.decode({}, filtered.span(), back.span());
  require(std::ranges::equal(raw, back.span()));
  filter.decode({}, raw, back.span());
  filter.encode({}, back.span(), filtered.span());
  require(std::ranges::equal(raw, filtered.span()));
}

/// Compresses into `room` bytes. If that is enough, the result must decode to `raw`.
bool check_codec(Codec& codec, std::span<const std::byte> raw, std::size_t room) {
  ExactBytes into(room);
  const std::optional<std::size_t> stored_bytes = codec.compress(raw, into.span());
  if (!stored_bytes) return false;
  require(*stored_bytes <= room);
  ExactBytes stored(into.span().first(*stored_bytes)), back(raw.size());
  codec.decompress(stored.span(), back.span());
  require(std::ranges::equal(raw, back.span()));
  return true;
}

void check_coder(BlockCoder& coder, const Filters& filters, std::span<const std::byte> raw) {
  const EncodedBlock encoded = coder.encode({filters}, raw);
  if (encoded.encoding == BlockEncoding::kRaw) {
    require(std::ranges::equal(raw, encoded.bytes));
    return;
  }
  require(encoded.encoding == BlockEncoding::kEncoded);
  require(!encoded.bytes.empty() && encoded.bytes.size() <= max_encoded_bytes(raw.size()));
  ExactBytes stored(encoded.bytes), back(raw.size());
  coder.decode({filters}, stored.span(), back.span());
  require(std::ranges::equal(raw, back.span()));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  InputBytes input(data, size);
  const CodingInput coding = take_coding(input);
  const std::size_t room = input.take<std::uint16_t>();
  ExactBytes block(input.rest());
  const std::span<const std::byte> raw = block.span();

  const Filters filters = coding.filters();
  for (const auto& filter : filters) check_filter(*filter, raw);
  const auto codec = coding.codec();
  check_codec(*codec, raw, room);
  require(check_codec(*codec, raw, codec->bound(raw.size())));
  // The coder is made for larger blocks, and codes more than one.
  BlockCoder coder = coding.coder(raw.size() + room);
  check_coder(coder, filters, raw);
  check_coder(coder, filters, raw.first(raw.size() / 2));
  check_coder(coder, filters, raw);
  return 0;
}
