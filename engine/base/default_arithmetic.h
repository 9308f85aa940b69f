// base/default_arithmetic.h: floating-point arithmetic whose results are stored.
#pragma once

#include <cfenv>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// Rounds to nearest and keeps denormal numbers while it exists, whatever the program has set: a
/// writer and a reader must compute the same predictions.
class DefaultArithmetic {
 public:
  DefaultArithmetic() noexcept {
    std::fegetenv(&former_);
    std::fesetenv(FE_DFL_ENV);
  }
  ~DefaultArithmetic() { std::fesetenv(&former_); }
  DefaultArithmetic(const DefaultArithmetic&) = delete;
  DefaultArithmetic& operator=(const DefaultArithmetic&) = delete;

 private:
  std::fenv_t former_;
};

PLAIT_END_NAMESPACE
