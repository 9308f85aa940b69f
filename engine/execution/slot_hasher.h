// The hash of slots, of which a digest is the sum (plait/digest.h).
#pragma once

#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <string_view>

#include "plait/digest.h"
#include "plait/error.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Hashes slots one after another and sums the hashes. Each thread has its own object.
class SlotHasher {
 public:
  /// Errors: kOutOfMemory.
  SlotHasher() : state_(XXH3_createState()) {
    if (!state_) throw Error(ErrorCode::kOutOfMemory, "digest: no memory for the hash state");
  }

  void add(VertexId start, VertexId end, int level, std::string_view attribute,
           std::span<const std::byte> bytes) noexcept {
    const std::uint32_t head[3] = {std::min(start, end), std::max(start, end),
                                   static_cast<std::uint32_t>(level)};
    const std::size_t before = sizeof(head) + attribute.size() + 1;
    XXH128_hash_t hash;
    // Most slots are short: a hash of one piece then takes half of the time.
    if (before + bytes.size() <= message_.size()) {
      std::memcpy(message_.data(), head, sizeof(head));
      std::memcpy(&message_[sizeof(head)], attribute.data(), attribute.size());
      message_[before - 1] = std::byte{0};
      if (!bytes.empty()) std::memcpy(&message_[before], bytes.data(), bytes.size());
      hash = XXH3_128bits(message_.data(), before + bytes.size());
    } else {
      constexpr char kEnd = 0;
      XXH3_128bits_reset(state_.get());
      XXH3_128bits_update(state_.get(), head, sizeof(head));
      XXH3_128bits_update(state_.get(), attribute.data(), attribute.size());
      XXH3_128bits_update(state_.get(), &kEnd, 1);
      XXH3_128bits_update(state_.get(), bytes.data(), bytes.size());
      hash = XXH3_128bits_digest(state_.get());
    }
    add({hash.high64, hash.low64});
  }
  void add(const Digest& other) noexcept {
    sum_.low += other.low;
    sum_.high += other.high + (sum_.low < other.low ? 1 : 0);
  }
  const Digest& sum() const { return sum_; }

 private:
  struct Free {
    void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
  };
  std::unique_ptr<XXH3_state_t, Free> state_;
  std::array<std::byte, 512> message_;
  Digest sum_;
};

PLAIT_END_NAMESPACE
