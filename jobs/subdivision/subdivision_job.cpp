#include "plait/subdivision_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "base/stopwatch.h"
#include "job_rules.h"
#include "mesh/narrowing.h"
#include "mesh/weld.h"
#include "plait/error.h"
#include "subdivision/earlier_run.h"
#include "subdivision/mesh_in_pieces.h"
#include "subdivision/planning.h"
#include "subdivision/run.h"
#include "subdivision/run_size.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

double SubdivisionResult::ns_per_vertex() const {
  const std::uint64_t made = plan.level_counts.back().vertices - plan.level_counts.front().vertices;
  return made == 0 ? 0 : 1e9 * refine_seconds / static_cast<double>(made);
}

struct SubdivisionJob::Implementation {
  Implementation(SubdivisionRequest asked, const BackendRegistry& registry)
      : request(std::move(asked)), backends(registry), plan(plan_request(request, registry)) {}

  void read_mesh();
  void plan_mesh();

  SubdivisionRequest request;
  const BackendRegistry& backends;
  SubdivisionPlan plan;
  std::optional<Store> store;  ///< the store of the earlier run; during run() the store of the run
  BaseMesh mesh;               ///< until run()
  bool was_run = false;
};

void SubdivisionJob::Implementation::read_mesh() {
  const Stopwatch clock;
  std::string source = "mesh";
  std::optional<BaseInRanges> pieces = mesh_in_pieces(request, plan);
  if (!plan.refusals.empty()) return;
  if (pieces) {
    source = std::get<std::filesystem::path>(request.mesh).native();
    mesh = pieces->mesh().in_pieces(plan.piece_bytes);
  } else if (const auto* const file = std::get_if<std::filesystem::path>(&request.mesh)) {
    source = file->native();
    mesh = mesh_of_file(*file, request.weld, plan.merged_vertices, plan.warnings);
  } else {
    mesh = std::get<BaseMesh>(std::exchange(request.mesh, BaseMesh()));
  }
  const auto ask_precision = [&](std::optional<ComponentType> asked) {
    if (pieces && asked && *asked != ComponentType::kFloat32) return *asked;
    return pieces ? precision_for(pieces->narrowing(request.levels), asked, source, plan.warnings)
                  : precision_for(mesh.positions(), mesh.faces(), request.levels, asked, source,
                                  plan.warnings);
  };
  const bool makes_levels = !plan.earlier || plan.earlier->level < request.levels;
  if (makes_levels) plan.precision = ask_precision(store ? plan.precision : request.precision);
  plan.seam_vertices = pieces ? pieces->seam_vertices() : seam_vertices_of(mesh);
  if (plan.seam_vertices > 0)
    plan.warnings.push_back(fmt::format("{}: {}", source, seam_text(plan.seam_vertices)));
  plan.import_seconds = clock.seconds();
  plan.input = {mesh.vertex_count(), mesh.edge_count(), mesh.face_count(),
                mesh.border_edge_count()};
  for (int level = 0; level <= request.levels; ++level)
    plan.level_counts.push_back(counts_at_level(mesh, level));
}

void SubdivisionJob::Implementation::plan_mesh() {
  if (!store)
    plan.base_level = rebase_levels(request.levels, 3 * component_bytes(plan.precision),
                                    request.max_slot_bytes.value_or(kLargestSlotBytes));
  plan.size = size_of_run(mesh, request, plan);
  if (plan.store.backend == kAutomaticBackend) {
    BackendChoice choice =
        backends.choose({.path = request.store, .level_bytes = plan.size.level_bytes});
    plan.store.backend = std::move(choice.name);
    plan.backend_reason = std::move(choice.reason);
  }
  const BackendTraits traits = backends.find(plan.store.backend).traits;
  refuse_pieces(request, traits, plan);
  if (request.ignore_size) return;
  check_memory(plan, traits);
  check_disk(plan, traits, request.store);
}

SubdivisionJob::SubdivisionJob(SubdivisionRequest request, const BackendRegistry& backends)
    : implementation_(std::make_unique<Implementation>(std::move(request), backends)) {
  Implementation& job = *implementation_;
  if (!job.plan.refusals.empty()) return;
  check_name(job.request, job.plan);
  job.store = open_earlier_run(job.request, backends, job.plan);
  if (!job.store) check_compression(job.request, backends, job.plan);
  if (!job.plan.refusals.empty()) return;
  job.read_mesh();
  if (!job.plan.refusals.empty()) return;
  check_bounds(job.request, job.mesh, job.plan);
  if (!job.plan.refusals.empty()) return;
  job.plan_mesh();
}

SubdivisionJob::SubdivisionJob(SubdivisionJob&&) noexcept = default;
SubdivisionJob& SubdivisionJob::operator=(SubdivisionJob&&) noexcept = default;
SubdivisionJob::~SubdivisionJob() = default;

const SubdivisionPlan& SubdivisionJob::plan() const { return implementation_->plan; }

SubdivisionResult SubdivisionJob::run(const JobWatch& watch) try {
  Implementation& job = *implementation_;
  if (std::exchange(job.was_run, true))
    throw Error(ErrorCode::kBadState, "subdivide: this job has already run: make another job");
  throw_refusal(job.plan);
  PlannedRun planned(job.request, job.backends, job.plan, job.store, watch);
  try {
    planned.open_store(planned.make_base(std::move(job.mesh)));
    planned.make_levels();
    planned.prune();
    planned.read_back();
    planned.publish();
  } catch (const Error& error) {
    const bool keeps_commits = job.plan.commits_levels && job.store;
    job.store.reset();
    if (!keeps_commits || error.code() != ErrorCode::kCancelled) throw;
    throw Error(error, fmt::format("{}; the last commit of {} stays", error.what(),
                                   job.request.store.native()));
  }
  planned.result().plan = job.plan;
  return std::move(planned.result());
} catch (const std::bad_alloc&) {
  throw out_of_memory("subdivide");
}

PLAIT_END_NAMESPACE
