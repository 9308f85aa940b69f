// A one-ring rule of the library. It is like a program's own rule, except for the row functions,
// which use the best instruction set of the processor.
#pragma once

#include <memory>

#include "plait/own_rule.h"
#include "rows/dispatched_rows.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

template <class Rule, class Real>
OneRing<Real> library_rule() {
  OneRingFunctions<Real> functions = functions_of<Real, Rule>();
  choose_rows<Rule>(functions);
  return OneRing<Real>(std::make_shared<const Rule>(), functions);
}

PLAIT_END_NAMESPACE
