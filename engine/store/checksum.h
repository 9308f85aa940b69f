// XXH3-64 of a run of bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace plait {

std::uint64_t checksum_of(std::span<const std::byte> bytes);

}  // namespace plait
