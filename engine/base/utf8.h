// Texts of people: which bytes are well-formed UTF-8.
#pragma once

#include <string_view>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Whether `text` is well-formed UTF-8 and has no control character but tab and line feed. Source:
/// The Unicode Standard, version 15.0 (2022), table 3-7. Pinned by tests/engine/base/utf8_test.cpp.
bool is_utf8_text(std::string_view text) noexcept;

PLAIT_END_NAMESPACE
