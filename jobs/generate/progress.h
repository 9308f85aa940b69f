// generate/progress.h: a step of the work reports a fraction from 0 to 1, which this class converts
// to a fraction of the whole work.
#pragma once

#include "generate/generate.h"

PLAIT_BEGIN_NAMESPACE
namespace generation {

class Progress {
 public:
  explicit Progress(const GeneratorProgress& report, double begin = 0, double end = 1)
      : report_(&report), begin_(begin), end_(end) {}

  void operator()(double fraction) const { (*report_)(begin_ + fraction * (end_ - begin_)); }
  Progress part(double begin, double end) const {
    return Progress(*report_, begin_ + begin * (end_ - begin_), begin_ + end * (end_ - begin_));
  }

 private:
  const GeneratorProgress* report_;
  double begin_, end_;
};

}  // namespace generation
PLAIT_END_NAMESPACE
