#include "job.h"
#include "parts/part_tables.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

const std::vector<Job>& all_jobs() {
  static const std::vector<Job> jobs = [] {
    std::vector<Job> made;
    made.push_back(subdivide_job());
    made.push_back(plan_job());
    made.push_back(part_job());
    made.push_back(join_job());
    made.push_back(status_job());
    made.push_back(import_job());
    made.push_back(remesh_job());
    made.push_back(check_job());
    made.push_back(compare_job());
    made.push_back(export_job());
    made.push_back(convert_job());
    made.push_back(prune_job());
    made.push_back(publish_job());
    made.push_back(pass_job());
    made.push_back(generate_job());
    made.push_back(layout_job());
    made.push_back(render_job());
    return made;
  }();
  return jobs;
}

PLAIT_END_NAMESPACE
