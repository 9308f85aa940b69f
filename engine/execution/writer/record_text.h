// The numbers of a record, for messages.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "plait/attribute.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// "(0.5, 1, 2)", or "7" for a record of one component. Numbers are written so that no two texts of
/// different finite numbers are equal.
std::string record_text(const AttributeSchema& schema, std::span<const std::byte> record);

PLAIT_END_NAMESPACE
