// A manifest slot, unchanged, and again with the right magic and checksum. Encoding the decoded
// slot must give the same fields, and decoding these must give the same result again.
#include "format/manifest.h"

#include <algorithm>
#include <cstring>

#include "format/byte_order.h"
#include "format/checksum.h"
#include "memory_file.h"
#include "oracle.h"

using namespace plait;
using namespace plait::fuzz;

namespace {

constexpr std::size_t kChecksumOffset = 4088;

Manifest read_file(const std::uint8_t* data, std::size_t size) {
  return read_manifest(File(path_of(data, size), OpenMode::kRead));
}

void check_decoded(const Manifest& manifest, const ManifestSlot& slot) {
  const ManifestSlot encoded = encode_manifest(manifest);
  require(is_whole_slot(encoded));
  require(encode_manifest(decode_manifest(encoded, "encoded")) == encoded);
  // Compares the version and the required flags, and everything behind the optional flags.
  require(std::ranges::equal(std::span(slot).subspan(8, 8), std::span(encoded).subspan(8, 8)));
  require(std::ranges::equal(std::span(slot).subspan(24, 40), std::span(encoded).subspan(24, 40)));
}

void check_slot(const ManifestSlot& slot) {
  const bool decoded = accepts({ErrorCode::kCorruption, ErrorCode::kNotSupported},
                               [&] { check_decoded(decode_manifest(slot, "slot"), slot); });
  const bool read = accepts({ErrorCode::kCorruption, ErrorCode::kNotSupported}, [&] {
    const Manifest manifest =
        read_file(reinterpret_cast<const std::uint8_t*>(slot.data()), slot.size());
    require(encode_manifest(manifest) == encode_manifest(decode_manifest(slot, "slot")));
  });
  require(read == (decoded && is_whole_slot(slot)));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  // The input is also a whole file, of any length and with any two slots.
  accepts({ErrorCode::kCorruption, ErrorCode::kNotSupported}, [&] { read_file(data, size); });

  ManifestSlot slot{};
  if (size > 0) std::memcpy(slot.data(), data, std::min(size, slot.size()));
  check_slot(slot);

  const ManifestSlot magic = encode_manifest({});
  std::copy(magic.begin(), magic.begin() + 8, slot.begin());
  save(std::span<std::byte>(slot), kChecksumOffset,
       checksum_of(std::span(slot).first(kChecksumOffset)));
  require(is_whole_slot(slot));
  check_slot(slot);
  return 0;
}
