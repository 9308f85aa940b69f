// tools/final_name.h: errors of what is built under a temporary name tell the name that the user
// gave.
#pragma once

#include "partial_output.h"
#include "plait/error.h"

namespace plait {

/// `error` with every name that begins with output.path() replaced by output.final_path().
Error with_final_name(const Error& error, const PartialOutput& output);

/// Returns what `work` does; its errors have passed with_final_name().
template <class Work>
auto build_output(const PartialOutput& output, Work work) {
  try {
    return work();
  } catch (const Error& error) {
    throw with_final_name(error, output);
  }
}

}  // namespace plait
