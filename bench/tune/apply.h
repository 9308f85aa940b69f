// bench/tune/apply.h: converts a store as advised.
#pragma once

#include <filesystem>

#include "plait/progress.h"
#include "tune/choice.h"

namespace plait::tune {

/// What the copy is beside what the advice named.
struct Applied {
  std::filesystem::path store;
  double stored_bytes = 0, seconds = 0;
};

/// Makes a copy of `source` at `out`, as `plait convert` makes it. `force` replaces a store.
/// Errors: those of copy_levels(), PartialStore and Store::create; kCancelled if `progress` returns
/// false, and then there is no copy.
Applied apply(Store& source, const Choice& choice, const std::filesystem::path& out, bool force,
              const BackendRegistry& backends, const ProgressCallback& progress);

}  // namespace plait::tune
