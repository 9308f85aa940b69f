// Any bytes decoded by any codec and filter chain into a block of any size: it is filled, the same
// way each time, or refused; not a byte outside it is touched.
//
// Input: coding, size of the block, then the stored bytes.
#include <algorithm>
#include <cstdint>

#include "coding.h"
#include "compressed/block_coder.h"
#include "oracle.h"
#include "plait/backends/pipeline.h"

using namespace plait;
using namespace plait::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  InputBytes input(data, size);
  const Coding coding = take_coding(input);
  const std::size_t raw_bytes = input.take<std::uint16_t>();
  ExactBytes stored(input.rest()), filtered(raw_bytes), raw(raw_bytes), again(raw_bytes);

  const auto codec = make_codec(coding.codec);
  const FilterChain filters = make_filter_chain(coding.filter, coding.component_bytes);
  const bool decoded =
      accepts({ErrorCode::kCorruption}, [&] { codec->decompress(stored.span(), filtered.span()); });
  if (filters.empty())
    std::ranges::copy(filtered.span(), raw.span().begin());
  else
    filters[0]->decode(filtered.span(), raw.span());

  // The chain as a block goes through it, with a coder that is used for a second time.
  BlockCoder coder(make_pipeline({coding.filter, coding.codec}), coding.component_bytes, raw_bytes);
  if (stored.span().size() > max_encoded_bytes(raw_bytes)) return 0;
  for (int round = 0; round < 2; ++round) {
    const std::span<std::byte> buffer = coder.stored_buffer(stored.span().size());
    std::ranges::copy(stored.span(), buffer.begin());
    const bool decoded_again =
        accepts({ErrorCode::kCorruption}, [&] { coder.decode(buffer, again.span()); });
    require(decoded_again == decoded);
    require(!decoded || std::ranges::equal(raw.span(), again.span()));
  }
  return 0;
}
