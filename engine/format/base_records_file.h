// format/base_records_file.h: the file attributeA.base.S. It has the records of the base vertices,
// or fewer bytes: a zstd frame with their differences to what is known already. Byte table:
// docs/format.md.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "plait/attribute.h"
#include "plait/detail/namespace.h"
#include "plait/extend/vector3.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Whether records of this attribute are predicted from the positions of the base mesh.
bool follows_base_positions(const AttributeSchema& schema);

/// The bytes of the file. Returns `records` themselves if the frame would not be smaller, or so
/// small that a reader refuses it. `positions`: of the base mesh, read only if the attribute
/// follows them. Errors: kOutOfMemory.
std::vector<std::byte> encode_base_records(const AttributeSchema& schema,
                                           std::span<const std::byte> records,
                                           std::span<const Vector3<double>> positions);

/// Fills `records` from the bytes of the file. Returns why it cannot, or nothing. REQUIRES: there
/// is a position for each record if the attribute follows them.
std::optional<std::string> decode_base_records(const AttributeSchema& schema,
                                               std::span<const std::byte> stored,
                                               std::span<const Vector3<double>> positions,
                                               std::span<std::byte> records);

PLAIT_END_NAMESPACE
