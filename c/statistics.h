// statistics.h: the counts of a pager for a C program.
#pragma once

#include "plait.h"
#include "plait/extend/session.h"

namespace plait::c {

plait_paging_statistics statistics_of(const PagingStatistics& counted);

}  // namespace plait::c
