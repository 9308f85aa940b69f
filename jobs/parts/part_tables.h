// parts/part_tables.h: the jobs of stores that many processes make.
#pragma once

#include "job.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

Job plan_job();
Job part_job();
Job join_job();
Job status_job();

PLAIT_END_NAMESPACE
