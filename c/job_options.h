// job_options.h: what jobs take from a C program in the same form.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "plait.h"
#include "plait/attribute.h"
#include "plait/compression.h"
#include "plait/extend/rounding.h"

namespace plait::c {

/// The choices of the option --compress of the program. Errors: kInvalidArgument for NULL; those of
/// Compression::add.
Compression compression_of(const char* const* texts, std::uint64_t count);
/// The choices of the option --max-error. Errors: kInvalidArgument for NULL; those of
/// ErrorBounds::add.
ErrorBounds bounds_of(const char* const* texts, std::uint64_t count);

/// The option --weld. Errors: kInvalidArgument for a tolerance without weld.
std::optional<double> weld_of(std::int32_t weld, double tolerance);
/// The option --precision; 0 is auto. Errors: kInvalidArgument for any other type than
/// PLAIT_FLOAT32 and PLAIT_FLOAT64.
std::optional<ComponentType> precision_of(plait_component_type precision);

/// Calls `warn`, if it is given.
std::function<void(const std::string&)> warnings_by(plait_warning warn, void* user);

}  // namespace plait::c
