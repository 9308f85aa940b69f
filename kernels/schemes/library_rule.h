// A one-ring rule of the library's: like a program's own, but for the rows, which are chosen for
// the processor at the time of the call.
#pragma once

#include <memory>

#include "plait/kernels/own_rule.h"
#include "rows/dispatched_rows.h"

namespace plait {

template <class Rule, class Real>
OneRing<Real> library_rule() {
  OneRingFunctions<Real> functions = functions_of<Real, Rule>();
  choose_rows<Rule>(functions);
  return OneRing<Real>(std::make_shared<const Rule>(), functions);
}

}  // namespace plait
