// A file of packed base records. What the reader accepts, it accepts again after packing, with the
// same bits.
//
// Input: a byte, the type; a byte, whether the records are positions; a byte, components; a byte,
// vertices; then the file.
#include "format/base_records_file.h"

#include "input_bytes.h"
#include "oracle.h"

using namespace plait;
using namespace plait::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  InputBytes input(data, size);
  const auto type = static_cast<ComponentType>(1 + input.take_below(10));
  const bool is_position = input.take_below(2) == 1;
  const auto components = static_cast<std::uint32_t>(1 + input.take_below(255));
  const std::size_t vertices = 1 + input.take<std::uint8_t>();
  const AttributeSchema schema = {is_position ? "position" : "other", type, components};
  std::vector<Vector3<double>> positions(vertices);
  for (std::size_t v = 0; v < vertices; ++v)
    positions[v] = {static_cast<double>(v), -1.5, 0x1p-30 * static_cast<double>(v)};
  ExactBytes file(input.rest()), records(vertices * schema.record_bytes());
  if (file.span().size() > records.span().size()) return 0;  // of which no version has a size
  if (decode_base_records(schema, file.span(), positions, records.span())) return 0;
  const std::vector<std::byte> again = encode_base_records(schema, records.span(), positions);
  ExactBytes back(records.span().size());
  require(!decode_base_records(schema, again, positions, back.span()));
  require(std::ranges::equal(back.span(), records.span()));
  return 0;
}
