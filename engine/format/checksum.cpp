#include "format/checksum.h"

#include <xxhash.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

std::uint64_t checksum_of(std::span<const std::byte> bytes) {
  return XXH3_64bits(bytes.data(), bytes.size());
}

std::uint64_t checksum_of(const File& file) {
  constexpr std::uint64_t kPartBytes = 1 << 20;
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(),
                                                                       &XXH3_freeState);
  if (!state) throw Error(ErrorCode::kOutOfMemory, "checksum of a file: no memory for its state");
  XXH3_64bits_reset(state.get());
  const std::uint64_t size = file.size();
  std::vector<std::byte> part(std::min(size, kPartBytes));
  for (std::uint64_t at = 0; at < size; at += part.size()) {
    const std::span<std::byte> bytes = std::span(part).first(std::min(kPartBytes, size - at));
    file.read_at(at, bytes);
    XXH3_64bits_update(state.get(), bytes.data(), bytes.size());
  }
  return XXH3_64bits_digest(state.get());
}

PLAIT_END_NAMESPACE
