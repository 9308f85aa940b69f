// base/byte_text.h: amounts of bytes as text, for messages.
#pragma once

#include <cstdint>
#include <string>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// "512 bytes", "1.50 KiB", "2.33 GiB". Pinned by tests/tools/arguments_test.cpp.
std::string format_bytes(std::uint64_t bytes);
/// The exact number with the largest unit that divides it: "1MiB", "65537". The program accepts
/// this text as a size.
std::string size_text(std::uint64_t bytes);

PLAIT_END_NAMESPACE
