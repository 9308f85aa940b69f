// tools/final_name.h: errors of what is built under a temporary name tell the name that the user
// gave.
#pragma once

#include <filesystem>

#include "plait/error.h"

namespace plait {

/// `error` with `temporary` replaced by `final_path`.
Error with_final_name(const Error& error, const std::filesystem::path& temporary,
                      const std::filesystem::path& final_path);

/// Returns what `work` does; its errors have passed with_final_name(). Output: PartialFile,
/// PartialOutput.
template <class Output, class Work>
auto build_output(const Output& output, Work work) {
  try {
    return work();
  } catch (const Error& error) {
    throw with_final_name(error, output.path(), output.final_path());
  }
}

}  // namespace plait
