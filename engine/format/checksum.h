// The checksum of bytes: XXH3-64.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "plait/extend/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

std::uint64_t checksum_of(std::span<const std::byte> bytes);

/// The checksum of a whole file. Needs little memory for any file. Errors: kIo, kOutOfMemory.
std::uint64_t checksum_of(const File& file);

PLAIT_END_NAMESPACE
