// A file version.S up to its block tables: as it comes, once more with the header's checksum made
// right, and the input as the description alone. What is accepted encodes again, and that decodes
// to the same.
#include "format/version_description.h"

#include <cstring>
#include <vector>

#include "format/byte_order.h"
#include "format/checksum.h"
#include "format/manifest.h"
#include "format/version_file.h"
#include "memory_file.h"
#include "oracle.h"

using namespace plait;
using namespace plait::fuzz;

namespace {

constexpr std::size_t kHeaderBytes = 32;
constexpr std::uint64_t kSequence = 9;

bool check_description(std::span<const std::byte> bytes, std::uint32_t features,
                       std::uint32_t required_features) {
  return accepts({ErrorCode::kCorruption, ErrorCode::kNotSupported}, [&] {
    const VersionDescription version =
        decode_description(bytes, kSequence, "version", features, required_features);
    require(version.attributes.size() <= bytes.size() / 30);
    require(version.shards.size() <= bytes.size() / 12);
    require(required_features_of(version) == required_features);
    const std::vector<std::byte> encoded = encode_description(version);
    const VersionDescription again =
        decode_description(encoded, kSequence, "encoded", optional_features_of(version),
                           required_features_of(version));
    require(encode_description(again) == encoded);
    require(again.provenance == version.provenance);
    require(again.shards == version.shards);
    require(again.depths == version.depths);
  });
}

bool check_description(std::span<const std::byte> bytes) {
  check_description(bytes, kKnownOptionalFeatures, 0);
  check_description(bytes, kKnownOptionalFeatures, kShards);
  check_description(bytes, 0, kShards);
  check_description(bytes, 0, kShards | kSharedFiles);
  check_description(bytes, kKnownOptionalFeatures, kDepths);
  check_description(bytes, 0, kDepths);
  return check_description(bytes, 0, 0);
}

void check_file(std::span<const std::byte> file) {
  accepts({ErrorCode::kCorruption}, [&] {
    const auto* const data = reinterpret_cast<const std::uint8_t*>(file.data());
    const std::vector<std::byte> description =
        read_description(File(path_of(data, file.size()), OpenMode::kRead));
    require(description.size() <= file.size() - kHeaderBytes);
    check_description(description);
  });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto input = std::as_bytes(std::span(data, size));
  check_file(input);
  check_description(input);
  if (size < kHeaderBytes) return 0;
  check_description(input.subspan(kHeaderBytes));
  std::vector<std::byte> right = encode_version_file({}, {});
  right.insert(right.end(), input.begin() + kHeaderBytes, input.end());
  save(std::span(right), 16, std::uint64_t{size - kHeaderBytes});
  save(std::span(right), 24, checksum_of(std::span(right).subspan(kHeaderBytes)));
  check_file(right);
  return 0;
}
