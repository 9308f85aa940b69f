// tools/final_name.h: while an output is built under a temporary name, error messages give the name
// that the user gave.
#pragma once

#include <filesystem>

#include "plait/error.h"

namespace plait {

/// `error` with `temporary` replaced by `final_path`.
Error with_final_name(const Error& error, const std::filesystem::path& temporary,
                      const std::filesystem::path& final_path);

/// Calls `work` and returns its result. Errors of `work` get the final name by with_final_name().
/// Output is PartialFile or PartialOutput.
template <class Output, class Work>
auto build_output(const Output& output, Work work) {
  try {
    return work();
  } catch (const Error& error) {
    throw with_final_name(error, output.path(), output.final_path());
  }
}

}  // namespace plait
