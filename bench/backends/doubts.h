// bench/backends/doubts.h: what limits the trust in a set of runs. Records hold figures and proofs,
// and no judgement: each doubt, with its threshold, is found here and nowhere else.
#pragma once

#include <string>
#include <vector>

#include "backends/findings.h"

namespace plait::bench {

struct DoubtLines {
  /// Those that spoil every figure: the page cache may have served the runs. They stand before a
  /// table, the others after it.
  std::vector<std::string> spoiling, others;
};

DoubtLines doubts_of(const RunSet& set, const std::vector<CellFigures>& cells);

}  // namespace plait::bench
