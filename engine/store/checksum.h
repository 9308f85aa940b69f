// XXH3-64 of a run of bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "plait/file.h"

namespace plait {

std::uint64_t checksum_of(std::span<const std::byte> bytes);

/// Of a whole file, in bounded memory. Errors: kIo, kOutOfMemory.
std::uint64_t checksum_of(const File& file);

}  // namespace plait
