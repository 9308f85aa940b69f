// The job "compare".
#include "compare/compare.h"
#include "job.h"
#include "plait/extend/edge_index.h"
#include "report_json.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

Job compare_job() {
  JobTable<ComparisonRequest> table("compare", "Measure the distances between two surfaces");
  table.path("a", &ComparisonRequest::first, "A mesh file or a store").at(0).required();
  table.path("b", &ComparisonRequest::second, "A mesh file or a store").at(1).required();
  table.count("level", &ComparisonRequest::level, 0, kMaxLevel,
              "The level of stores; default: the finest");
  table.count("samples", &ComparisonRequest::samples, 1, 1000000000,
              "Points on each surface, spread by area");
  table.threads(&ComparisonRequest::threads, "Worker threads");
  return table.run([](ComparisonRequest& request, const JobCall& call) -> JobReport {
    const SurfaceComparison found = compare_surfaces(request, call.open_backends, call.watch);
    return {{"a", request.first.string()},
            {"b", request.second.string()},
            {"diagonal", found.diagonal},
            {"mean_edge", found.mean_edge},
            {"a_to_b", distances_json(found.there, found.diagonal)},
            {"b_to_a", distances_json(found.back, found.diagonal)}};
  });
}

PLAIT_END_NAMESPACE
