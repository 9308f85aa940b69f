// job_options.h: what jobs take from a C program in the same form.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "plait.h"
#include "plait/compression.h"
#include "plait/extend/rounding.h"

namespace plait::c {

/// The choices of the option --compress of the program. Errors: kInvalidArgument for NULL; those of
/// Compression::add.
Compression compression_of(const char* const* texts, std::uint64_t count);
/// The choices of the option --max-error. Errors: kInvalidArgument for NULL; those of
/// ErrorBounds::add.
ErrorBounds bounds_of(const char* const* texts, std::uint64_t count);

/// Calls `warn`, if it is given.
std::function<void(const std::string&)> warnings_by(plait_warning warn, void* user);

}  // namespace plait::c
