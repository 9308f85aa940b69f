// The fields at the end of a version's description, each of which belongs to an optional feature.
#pragma once

#include <cstdint>

#include "format/field_stream.h"
#include "format/version_description.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Writes the fields of optional_features_of(version). Errors: those of encode_description().
void encode_optional_fields(const VersionDescription& version, FieldWriter& fields);

/// Takes the fields of these features. Errors: kCorruption.
void take_optional_fields(FieldReader& fields, VersionDescription& version,
                          std::uint32_t optional_features);

PLAIT_END_NAMESPACE
