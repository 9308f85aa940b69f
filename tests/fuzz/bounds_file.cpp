// A file of bounds: the first byte is the number of faces of the store, the rest is the file. It is
// read unchanged, and again with the right magic, length and checksum. If the reader accepts it,
// the bounds are exactly those in the bytes; with another key there are none.
#include "format/bounds_file.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <vector>

#include "format/byte_order.h"
#include "format/checksum.h"
#include "format/file_names.h"
#include "input_bytes.h"
#include "oracle.h"
#include "support/temporary_directory.h"

using namespace plait;
using namespace plait::fuzz;

namespace {

// docs/format.md, "attributeA.bounds".
constexpr std::size_t kHeaderBytes = 32, kBoundsBytes = 24, kChecksumBytes = 8;
constexpr std::uint32_t kAttribute = 3;

/// The only file of a directory.
class Place {
 public:
  Place() : store_(directory_.path()) {}
  const Directory& store() const { return store_; }
  void write(std::span<const std::byte> bytes) const {
    std::ofstream file(directory_.path() / bounds_file_name(kAttribute),
                       std::ios::binary | std::ios::trunc);
    file.write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    require(file.flush().good());
  }

 private:
  test::TemporaryDirectory directory_;
  Directory store_;
};

void check_bounds(std::span<const FaceBounds> faces, std::span<const std::byte> bytes) {
  for (std::size_t face = 0; face < faces.size(); ++face)
    for (std::size_t number = 0; number < 6; ++number) {
      const float found = number < 3 ? faces[face].low.at(number) : faces[face].high.at(number - 3);
      const auto expected =
          load<std::uint32_t>(bytes, kHeaderBytes + face * kBoundsBytes + number * sizeof(float));
      require(std::bit_cast<std::uint32_t>(found) == expected && !std::isnan(found));
    }
}

void try_file(const Place& place, std::uint64_t face_count, std::span<const std::byte> bytes) {
  place.write(bytes);
  const bool has_key = bytes.size() >= kHeaderBytes;
  const std::uint64_t key = has_key ? load<std::uint64_t>(bytes, 24) : 0;
  const bool right = accepts({ErrorCode::kCorruption},
                             [&] { check_bounds_file(place.store(), kAttribute, face_count); });
  const bool taken = accepts({ErrorCode::kCorruption}, [&] {
    const auto faces = read_bounds_file(place.store(), kAttribute, face_count, key);
    require(faces && faces->size() == face_count);
    require(bytes.size() == kHeaderBytes + face_count * kBoundsBytes + kChecksumBytes);
    check_bounds(*faces, bytes);
  });
  const bool stale = accepts({ErrorCode::kCorruption}, [&] {
    require(!read_bounds_file(place.store(), kAttribute, face_count, key + 1));
  });
  require(right == taken && right == stale);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Place place;
  InputBytes input(data, size);
  const std::uint64_t face_count = input.take_below(64);
  try_file(place, face_count, input.rest());

  std::vector<std::byte> bytes(input.rest().begin(), input.rest().end());
  bytes.resize(kHeaderBytes + face_count * kBoundsBytes + kChecksumBytes);
  std::memcpy(bytes.data(), "plaitbox", 8);
  const auto seal = [&] {
    const std::size_t content = bytes.size() - kChecksumBytes;
    save(std::span(bytes), content, checksum_of(std::span(bytes).first(content)));
  };
  seal();
  try_file(place, face_count, bytes);
  save(std::span(bytes), 8, std::uint32_t{1});
  save(std::span(bytes), 16, face_count);
  seal();
  try_file(place, face_count, bytes);
  return 0;
}
