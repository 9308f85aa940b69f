// tools/compress_arguments.h: what --compress and --max-error mean for the commands that make a
// store.
#pragma once

#include <string>
#include <vector>

#include "plait/compression.h"
#include "plait/options.h"
#include "plait/store.h"

namespace plait {

/// What the texts of --compress choose. Errors: as Compression::add().
Compression compression_of(const std::vector<std::string>& texts);
/// The pipelines that they choose for a store with the levels of `store`. Errors: also as
/// Compression::check_levels().
PipelinesOf pipelines_of(const std::vector<std::string>& texts, const Store& store);
/// The text about --max-error for --help.
std::string max_error_help();

}  // namespace plait
