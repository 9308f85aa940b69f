// tools/tune/apply.h: converts a store as advised, and holds the outcome against the prediction.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "plait/store.h"
#include "tune/advice.h"

namespace plait::tune {

struct Applied {
  std::filesystem::path store;
  Predicted predicted;
  double predicted_bytes = 0, stored_bytes = 0;  ///< block tables included
  /// Of the copy, committed durably. It contains reading the source, which the prediction leaves
  /// out.
  double write_seconds = 0;
  double read_seconds = 0;  ///< of all levels, cold if `is_cold`
  bool is_cold = true;
};

/// Makes a copy of `source` at `out` with the pipelines and the block size of the pick, and reads
/// it back. `force` replaces a store. Errors: those of copy_levels(), PartialStore and
/// Store::create; kCancelled if `proceed` returns false, and then there is no copy.
Applied apply(Store& source, const Findings& findings, const Advice& advice,
              const std::filesystem::path& out, bool force, const BackendRegistry& backends,
              const std::function<bool(std::uint64_t done, std::uint64_t total)>& proceed);

std::string to_text(const Applied& applied);
nlohmann::ordered_json to_json(const Applied& applied);

}  // namespace plait::tune
