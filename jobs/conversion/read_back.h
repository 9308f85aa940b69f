// conversion/read_back.h: reads a copy of a store from the disk and compares it with the original.
#pragma once

#include <filesystem>
#include <string>

#include "conversion/conversion_job.h"
#include "plait/detail/namespace.h"
#include "plait/extend/rounding.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

/// Begins a step of the job. Returns the callback for its progress, whose phase is the step. `step`
/// must be valid as long as the callback.
ProgressCallback begin_step(const JobWatch& watch, std::string_view step);

/// Opens the copy as any reader does, after removing it from the page cache, and compares its
/// digest with that of `source`. The digest covers all vertices of all attributes. Returns the
/// digest. REQUIRES: the copy was committed. Errors: kCorruption if the digests differ; as
/// Store::open and digest().
std::string compare_copy(Store& source, const std::filesystem::path& copy, const OpenOptions& open,
                         int threads, const BackendRegistry& backends, const JobWatch& watch = {});

/// The same for a copy whose records were rounded: compares every record with the original, and
/// computes the errors in long double. Attributes without a bound have to be equal. Errors: also
/// kCorruption if an error is too large.
std::string compare_rounded_copy(Store& source, const std::filesystem::path& copy,
                                 const OpenOptions& open, int threads,
                                 const BackendRegistry& backends, const ErrorBounds& bounds,
                                 const JobWatch& watch = {});

/// The same for a copy that has more levels of some faces: compares every record that `source` has.
std::string compare_filled_copy(Store& source, const std::filesystem::path& copy,
                                const OpenOptions& open, int threads,
                                const BackendRegistry& backends, const JobWatch& watch = {});

PLAIT_END_NAMESPACE
