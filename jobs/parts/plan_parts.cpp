#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <random>
#include <utility>

#include "base/default_arithmetic.h"
#include "base/text.h"
#include "format/base_index_file.h"
#include "format/file_names.h"
#include "job_rules.h"
#include "layout/base_directory.h"
#include "mesh/narrowing.h"
#include "mesh/weld.h"
#include "parts/base_in_ranges.h"
#include "parts/calibrate.h"
#include "parts/cuts.h"
#include "parts/part_work.h"
#include "parts/plan_figures.h"
#include "parts/plan_file.h"
#include "plait/error.h"
#include "plait/extend/fused.h"
#include "plait/extend/parts.h"
#include "plait/extend/provenance.h"
#include "plait/mesh_io.h"
#include "schemes/table.h"
#include "store/left_overs.h"
#include "store/new_output.h"
#include "store/store_checks.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr double kNsPerPointWithNormals = 8;

StoreUuid random_uuid() {
  std::random_device device;
  StoreUuid uuid;
  for (std::byte& byte : uuid) byte = static_cast<std::byte>(device() & 0xff);
  return uuid;
}

std::string pipeline_text(const PartsRequest& request, const RegisteredBackend& backend,
                          const AttributeSchema& schema) {
  const LevelPipelines pipelines = request.pipeline_of(schema);
  backend.check_pipelines(pipelines, schema);
  bool predicted = false;
  LevelPipelines searched = pipelines;
  searched.for_each([&](Pipeline& one) { predicted = predicted || one.has_predicted_stage(); });
  if (predicted || backend.needs_other_blocks(pipelines, schema))
    throw Error(ErrorCode::kNotSupported,
                fmt::format("plan parts: pipeline {} of '{}' encodes blocks with the help of other "
                            "blocks, and a part has only its own: take --compress fast, or convert "
                            "the joined store",
                            pipelines.to_text(), schema.name));
  return pipelines.to_text();
}

/// Of a vertex, of all attributes.
std::size_t bytes_of_records(const PlanFile& file) {
  const std::size_t normal = AttributeSchema{"normal", ComponentType::kFloat32, 3}.record_bytes();
  return AttributeSchema{"position", file.precision, 3}.record_bytes() +
         (file.normals ? normal : 0);
}

void check_request(const PartsRequest& request) {
  if (request.scheme.own() != nullptr)
    throw Error(ErrorCode::kNotSupported,
                "plan parts: a rule of the program's own has no name that another process knows");
  if (const SchemeTraits scheme = traits_of(request.scheme); request.limit && !scheme.has_limits)
    throw Error(ErrorCode::kNotSupported,
                fmt::format("plan parts: scheme {} has no limit positions", scheme.name));
  if (request.parts == 0)
    throw Error(ErrorCode::kInvalidArgument, "plan parts: expected at least 1 part, found 0");
  if (request.block_bytes != 0) check_block_bytes(request.block_bytes, "plan parts");
}

/// What a part of a mesh in a file takes of memory for each of its faces.
constexpr std::uint64_t kBytesOfFace = 160;

[[noreturn]] void refuse_ranges(const PartsRequest& request, const std::string& why) {
  throw JobError(
      ErrorCode::kBudget,
      fmt::format("plan parts: {} needs {} of memory as a whole, found {} for it: {}",
                  request.mesh.native(), format_bytes(BaseInRanges::whole_bytes(request.mesh)),
                  format_bytes(request.memory_bytes), why),
      "memory");
}

/// The base mesh if it is one in files that is larger than the memory for it.
std::optional<BaseInRanges> base_in_ranges(const PartsRequest& request,
                                           std::vector<std::string>& warnings) {
  if (!is_base_directory(request.mesh) || request.weld ||
      BaseInRanges::whole_bytes(request.mesh) <= request.memory_bytes)
    return std::nullopt;
  if (request.layout != kLayoutOfBaseDirectory)
    refuse_ranges(request,
                  fmt::format("layout {} orders all faces anew, {} keeps their order",
                              to_string(request.layout), to_string(kLayoutOfBaseDirectory)));
  if (traits_of(request.scheme).ring_count > 1)
    refuse_ranges(request,
                  fmt::format("each part of scheme {} reads all of it", to_string(request.scheme)));
  const std::filesystem::path plan = OutputName(request.plan).path;
  const BaseCounts counts = BaseInRanges::counts(request.mesh);
  const std::uint64_t disk = std::max(BaseInRanges::disk_of_narrowing(counts, request.memory_bytes),
                                      BaseInRanges::disk_of_edges(counts, request.memory_bytes));
  if (const auto line =
          disk_for_sorts(fmt::format("plan parts of {}", request.mesh.native()), plan, disk))
    warnings.push_back(*line);
  if (request.before_files) request.before_files();
  return std::make_optional<BaseInRanges>(request.mesh, plan, request.memory_bytes);
}

ComponentType precision_of(const PartsRequest& request, std::optional<BaseInRanges>& ranges,
                           const BaseMesh& mesh, std::vector<std::string>& warnings) {
  const std::string& source = request.mesh.native();
  if (!ranges)
    return precision_for(mesh.positions(), mesh.faces(), request.levels, request.precision, source,
                         warnings);
  if (request.precision && *request.precision != ComponentType::kFloat32) return *request.precision;
  return precision_for(ranges->narrowing(request.levels), request.precision, source, warnings);
}

/// memory_of_parts() makes the store of the largest part, and so does whoever makes the part.
void check_parts(const PartsRequest& request, const PartsPlan& plan) {
  const std::uint64_t faces = std::ranges::max_element(plan.parts, {}, &PlannedPart::faces)->faces;
  if (const std::uint64_t needed = kBytesOfFace * faces; needed > request.memory_bytes)
    throw JobError(
        ErrorCode::kBudget,
        fmt::format("plan parts: a part of {} faces needs {} of memory for its piece of the base "
                    "mesh, found {} for it: take more than {} parts",
                    faces, format_bytes(needed), format_bytes(request.memory_bytes), request.parts),
        "memory");
}

}  // namespace

PartCost cost_of_subdivision(const PlanFile& file) {
  PartCost cost;
  cost.levels = file.plan.levels - file.plan.base_level;
  cost.ns_per_record = kNsPerByte * static_cast<double>(bytes_of_records(file));
  cost.ns_per_point = file.normals ? kNsPerPointWithNormals : kNsPerPoint;
  return cost;
}

void add_figures(PlanFile& file, const BaseMesh& mesh, const EdgesInOrder& edges,
                 const std::vector<EdgeId>& starts) {
  PartsPlan& plan = file.plan;
  const PartCost cost = cost_of_subdivision(file);
  plan.parts = figures_of_parts(edges, starts, cost);
  for (PlannedPart& part : plan.parts) part.bytes = part.records * bytes_of_records(file);
  const std::uint64_t attributes = file.normals ? 2 : 1;
  const auto files = file.shares_files ? 1 : static_cast<std::uint64_t>(cost.levels);
  plan.files = plan.parts.size() * (attributes * files + 1) + attributes +
               4;  // and base records, base.mesh, version, manifest, lock
  if (wants_index({}, mesh)) ++plan.files;
}

PartMemory memory_of_parts(const Directory& plan_directory, const PlanFile& file,
                           const std::filesystem::path& final_path,
                           const BackendRegistry& backends) {
  constexpr std::uint64_t kMiB = 1u << 20, kOfProgram = 64 * kMiB, kOfFace = kBytesOfFace;
  // Positions and base records are in the order of the input, so that any part may touch all pages
  // of them.
  constexpr std::uint64_t kOfOtherFace = 40;
  const auto whole = [](std::uint64_t bytes) { return (bytes + kMiB - 1) / kMiB * kMiB; };
  const auto worst = std::ranges::max_element(file.plan.parts, {}, &PlannedPart::bytes);
  UnpublishedDirectory directory(final_path, "partial", MadeProof::kMark, remove_made_files);
  const Needs needs = PartWork::of(plan_directory, file)
                          ->needs(static_cast<std::uint32_t>(worst - file.plan.parts.begin()),
                                  directory.directory(), backends);
  PartMemory memory;
  // Parts differ a little; a backend keeps up to a quarter for itself.
  memory.budget_bytes = std::max(StoreOptions().budget_bytes,
                                 whole((4 * needs.frames / 3 + needs.resident) * 11 / 10));
  const bool reads_region = plan_directory.contains(kBaseIndexName) && !file.plan.pass &&
                            traits_of(scheme_from_name(file.scheme)).ring_count == 1;
  const std::uint64_t own =
      reads_region ? std::min(worst->faces, file.face_count) : file.face_count;
  memory.total_bytes = whole(memory.budget_bytes + kOfProgram + kOfFace * own +
                             kOfOtherFace * (file.face_count - own));
  return memory;
}

PartsPlan plan_parts(const PartsRequest& request, const BackendRegistry& backends) try {
  const DefaultArithmetic arithmetic;
  check_request(request);
  PlanFile file;
  PartsPlan& plan = file.plan;
  plan.backend = request.pipeline_of ? "compressed" : "pread";
  const RegisteredBackend& backend = backends.find(plan.backend);
  check_new_directory(request.plan);
  constexpr std::uint64_t kSteps = 4;
  const auto go_on = [&](std::uint64_t step) {
    if (request.progress && !request.progress({"plan", step, kSteps}))
      throw Error(ErrorCode::kCancelled, "plan parts: cancelled");
  };
  go_on(0);
  std::optional<BaseInRanges> ranges = base_in_ranges(request, plan.warnings);
  BaseMesh mesh =
      ranges ? ranges->mesh()
             : mesh_of_file(request.mesh, request.weld, plan.merged_vertices, plan.warnings);
  if (const std::uint64_t seams = ranges ? ranges->seam_vertices() : seam_vertices_of(mesh);
      seams > 0)
    plan.warnings.push_back(fmt::format("{}: {}", request.mesh.native(), seam_text(seams)));
  go_on(0);
  file.precision = precision_of(request, ranges, mesh, plan.warnings);
  go_on(1);
  const AttributeSchema position{"position", file.precision, 3};
  const AttributeSchema normal{"normal", ComponentType::kFloat32, 3};
  if (request.pipeline_of) {
    file.position_pipeline = pipeline_text(request, backend, position);
    if (request.normals) file.normal_pipeline = pipeline_text(request, backend, normal);
  }
  plan.vertices = counts_at_level(mesh, request.levels).vertices;
  plan.levels = request.levels;
  plan.base_level = rebase_levels(request.levels, position.record_bytes(),
                                  request.max_slot_bytes.value_or(kLargestSlotBytes));
  const int over_base = plan.levels - plan.base_level;
  if (over_base < 1 || over_base > kMostFusedLevels)
    throw Error(
        ErrorCode::kNotSupported,
        fmt::format("plan parts: level {} is {} levels over the base mesh, expected 1 to {} "
                    "(--max-slot)",
                    plan.levels, over_base, kMostFusedLevels));
  go_on(2);
  if (ranges && plan.base_level > 0)
    refuse_ranges(request, fmt::format("it is refined {} times in memory first (--max-slot)",
                                       plan.base_level));
  if (plan.base_level > 0)
    mesh = rebase(in_input_order(std::move(mesh)), plan.base_level, request.scheme, file.precision);
  LayoutKind layout = request.layout;
  if (!has_order(mesh, layout)) {
    LaidOutMesh ordered = laid_out(std::move(mesh), layout);
    mesh = std::move(ordered.mesh);
    layout = ordered.kind;
  }
  if (request.parts > mesh.edge_count() || request.parts > kMostShards)
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("plan parts: expected at most one part for each of {} edges and at most "
                    "{}, found {}",
                    mesh.edge_count(), kMostShards, request.parts));
  plan.uuid = random_uuid();
  plan.program = program_version();
  file.vertex_count = mesh.vertex_count();
  file.edge_count = mesh.edge_count();
  file.face_count = mesh.face_count();
  file.scheme = to_string(request.scheme);
  file.layout = to_string(layout);
  file.normals = request.normals;
  file.limit = request.limit;
  file.shares_files = backend.traits.shares_files;
  file.block_bytes =
      request.block_bytes != 0 ? request.block_bytes : default_block_bytes(backend.traits);

  const PartCost cost = cost_of_subdivision(file);
  const std::unique_ptr<EdgesInOrder> edges =
      ranges ? ranges->edges() : std::make_unique<EdgesInMemory>(mesh.topology());
  add_figures(file, mesh, *edges, cut_edges(*edges, request.parts, cost));
  if (ranges) check_parts(request, plan);
  const bool has_index = wants_index({}, mesh);
  go_on(3);

  if (request.before_files && !ranges) request.before_files();
  make_new_directory(
      request.plan, [&](const std::string& what) { plan.warnings.push_back(what); }, remove_plan,
      [&](const Directory& directory) {
        file.base_mesh = write_base_mesh_file(directory, mesh);
        go_on(3);
        if (has_index)
          write_base_index_file(directory, kBaseIndexName, mesh, file.base_mesh.checksum, true);
        go_on(3);
        if (request.calibrate) {
          plan.rates = measure_machine(directory, file, *edges, cost, OutputName(request.plan).path,
                                       request.progress, backends);
          for (PlannedPart& part : plan.parts) part.seconds = seconds_of(part, cost, *plan.rates);
        }
        plan.memory = memory_of_parts(directory, file, OutputName(request.plan).path, backends);
        write_plan_file(directory, file);
      });
  return plan;
} catch (const std::bad_alloc&) {
  throw out_of_memory("plan parts");
}

PartsPlan read_parts_plan(const std::filesystem::path& plan) {
  return read_plan_file(open_plan_directory(plan)).plan;
}

PLAIT_END_NAMESPACE
