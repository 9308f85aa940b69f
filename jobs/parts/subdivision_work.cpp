#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "base/stopwatch.h"
#include "base/text.h"
#include "conversion/conversion_job.h"
#include "execution/part_digest.h"
#include "format/base_index_file.h"
#include "format/base_mesh_file.h"
#include "format/checksum.h"
#include "format/file_names.h"
#include "parts/base_records.h"
#include "parts/link_or_copy.h"
#include "parts/mend_shards.h"
#include "parts/part_work.h"
#include "parts/sealed_file.h"
#include "plait/error.h"
#include "plait/extend/file.h"
#include "plait/extend/store_access.h"
#include "plait/progress.h"
#include "plait/subdivide.h"
#include "schemes/table.h"
#include "store/lock.h"
#include "store/recovery.h"
#include "store/store_directory.h"
#include "store/unpublished_store.h"
#include "store/version_writer.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

class SubdivisionWork : public PartWork {
 public:
  SubdivisionWork(const Directory& plan_directory, const PlanFile& plan)
      : PartWork(plan_directory, plan) {}

  ComputedPart compute(std::uint32_t part, const Directory& directory, const PartOptions& options,
                       const BackendRegistry& backends) const override;
  Needs needs(std::uint32_t part, const Directory& directory,
              const BackendRegistry& backends) const override;
  void check(const JoinCall& call) override;
  bool is_joined() const override { return is_joined_; }
  bool needs_all_parts() const override { return !is_joined_; }
  std::unique_ptr<PartBlocks> blocks(const JoinCall& call,
                                     const std::vector<DoneFile>& parts) override;
  void commit(const JoinCall& call, const std::vector<DoneFile>& parts, const std::string& digest,
              const std::function<void(std::uint32_t)>& tell) override;

 private:
  EdgeShards shards() const { return {plan_.starts(), plan_.edge_count}; }
  VersionDescription description_of(const std::vector<DoneFile>& parts) const {
    return decode_description(parts.front().description, 1, directory_.path());
  }
  File open_base() const;
  BaseMesh read_mesh(const File& file) const;
  BaseMesh mesh_of_part(std::uint32_t part) const;
  Store create_store(std::uint32_t part, const Directory& directory, const BaseMesh& mesh,
                     const PartOptions& options, const BackendRegistry& backends) const;
  SubdivideOptions options_of(const PartOptions& options) const;
  void make_store(const std::filesystem::path& path, const std::vector<DoneFile>& parts,
                  const std::function<void(std::uint32_t)>& tell) const;
  void publish(const JoinCall& call, UnpublishedStore& output);
  StoreUuid uuid_of_result(const JoinOptions& options) const;
  bool is_store_of_plan(const std::filesystem::path& path, const StoreUuid& uuid) const;

  // For a join.
  bool is_joined_ = false;
  File base_;
  BaseMesh mesh_;
  VersionDescription description_;
  EdgeShards shards_;
};

File SubdivisionWork::open_base() const {
  File base(directory_, kBaseMeshName, OpenMode::kRead);
  refuse_hole(base);
  return base;
}

BaseMesh SubdivisionWork::read_mesh(const File& file) const {
  if (directory_.contains(kBaseIndexName)) {
    refuse_hole(File(directory_, kBaseIndexName, OpenMode::kRead));
    const std::uint64_t border_edges = 2 * plan_.edge_count - 3 * plan_.face_count;
    if (auto mesh = open_base_index_file(
            directory_, {{plan_.vertex_count, plan_.edge_count, plan_.face_count, border_edges},
                         plan_.base_mesh.checksum,
                         "; remove the file: each part then computes the base mesh again"}))
      return *std::move(mesh);
  }
  BaseMesh mesh = read_base_mesh_file(file, plan_.base_mesh, plan_.vertex_count, plan_.face_count);
  if (mesh.edge_count() != plan_.edge_count)
    throw Error(ErrorCode::kCorruption,
                fmt::format("open {}: expected {} edges, found {}", file.path().native(),
                            plan_.edge_count, mesh.edge_count()));
  return mesh;
}

/// With the index of the base mesh, a part reads what it needs. Level 1 of a scheme of two rings is
/// made of the whole base mesh.
BaseMesh SubdivisionWork::mesh_of_part(std::uint32_t part) const {
  BaseMesh mesh = read_mesh(open_base());
  if (traits_of(scheme_from_name(plan_.scheme)).ring_count > 1) return mesh;
  return mesh.around(shards().first_edge(part), shards().edge_after(part));
}

Store SubdivisionWork::create_store(std::uint32_t part, const Directory& directory,
                                    const BaseMesh& mesh, const PartOptions& options,
                                    const BackendRegistry& backends) const {
  StoreOptions store;
  store.backend = plan_.plan.backend;
  store.block_bytes = plan_.block_bytes;
  store.budget_bytes = options.budget_bytes;
  store.parallel_for = options.parallel_for;
  if (!plan_.position_pipeline.empty())
    store.pipeline_of = [position = plan_.position_pipeline,
                         normal = plan_.normal_pipeline](const AttributeSchema& schema) {
      return LevelPipelines(schema.name == "normal" ? normal : position);
    };
  Store made = create_part_store(directory.path(), mesh, store, backends,
                                 {.layout = plan_.layout, .base_level = plan_.plan.base_level},
                                 {plan_.plan.uuid, shards(), part, plan_.base_mesh});
  add_base_positions(made, plan_.precision);
  return made;
}

SubdivideOptions SubdivisionWork::options_of(const PartOptions& options) const {
  SubdivideOptions subdivision;
  subdivision.scheme = scheme_from_name(plan_.scheme);
  subdivision.levels = plan_.plan.levels;
  subdivision.normals = plan_.normals;
  subdivision.limit = plan_.limit;
  subdivision.executor = ExecutorKind::kFused;
  subdivision.threads = options.threads;
  subdivision.progress = options.progress;
  return subdivision;
}

Needs SubdivisionWork::needs(std::uint32_t part, const Directory& directory,
                             const BackendRegistry& backends) const {
  Store store = create_store(part, directory, mesh_of_part(part), {}, backends);
  return plan_subdivision(store, options_of({})).needs();
}

/// The most threads, at most `wanted`, whose frames and scratch memory fit the budget, and what the
/// scratch memory leaves for blocks. One thread is always allowed: then its scratch memory may come
/// on top of the budget.
struct FittingThreads {
  int threads = 1;
  std::uint64_t block_bytes = 0;
  std::uint64_t over = 0;  ///< bytes on top of the budget
};

FittingThreads threads_that_fit(Store& store, SubdivideOptions options, int wanted,
                                std::uint64_t budget) {
  for (int threads = wanted;; threads = std::max(1, threads - std::max(1, threads / 4))) {
    options.threads = threads;
    const Needs needs = plan_subdivision(store, options).needs();
    // A backend keeps up to a quarter of the budget for itself.
    const std::uint64_t frames = (4 * needs.frames + 2) / 3;
    if (frames + needs.resident <= budget) return {threads, budget - needs.resident, 0};
    if (threads == 1) return {1, budget, needs.resident};
  }
}

ComputedPart SubdivisionWork::compute(std::uint32_t part, const Directory& directory,
                                      const PartOptions& options,
                                      const BackendRegistry& backends) const {
  ComputedPart computed;
  const Stopwatch clock;
  const BaseMesh mesh = mesh_of_part(part);
  std::optional<Store> made(create_store(part, directory, mesh, options, backends));
  SubdivideOptions subdivision = options_of(options);
  const int wanted = thread_count(options.threads, "make part");
  const FittingThreads fitting = threads_that_fit(*made, subdivision, wanted, options.budget_bytes);
  subdivision.threads = fitting.threads;
  if (options.warn && fitting.threads < wanted)
    options.warn(
        fmt::format("part {}: {} threads of {}: the scratch memory of more does not fit "
                    "the budget of {} (--memory)",
                    part, fitting.threads, wanted, format_bytes(options.budget_bytes)));
  if (options.warn && fitting.over > options.budget_bytes / 4)
    options.warn(fmt::format("part {}: {} of scratch memory come on top of the budget of {}", part,
                             format_bytes(fitting.over), format_bytes(options.budget_bytes)));
  if (fitting.block_bytes < options.budget_bytes) {
    PartOptions less = options;
    less.budget_bytes = fitting.block_bytes;
    made.reset();  // before the next one: both have the same directory
    made.emplace(create_store(part, directory, mesh, less, backends));
  }
  Store& store = *made;
  computed.begin_seconds = clock.seconds();
  subdivide(store, subdivision);
  const double refined = clock.seconds();
  computed.content = finish_part_store(store);
  computed.description = encode_description(computed.content.description);
  const double written = clock.seconds();
  std::vector<AttributeId> all(store.attributes().size());
  std::iota(all.begin(), all.end(), 0);
  computed.digest = digest_of_part(store, *StoreAccess::own_vertices(store), all, options.progress);
  store.close();
  computed.write_seconds = written - refined;
  computed.compute_seconds = clock.seconds() - computed.write_seconds - computed.begin_seconds;
  return computed;
}

void SubdivisionWork::check(const JoinCall& call) {
  base_ = open_base();
  if (base_.size() != plan_.base_mesh.bytes || checksum_of(base_) != plan_.base_mesh.checksum)
    throw Error(ErrorCode::kCorruption, fmt::format("join {}: {} is not that of the plan",
                                                    call.plan.native(), base_.path().native()))
        .about(base_.path());
  is_joined_ = call.options.existing == Existing::kRefuse &&
               is_store_of_plan(call.store, uuid_of_result(call.options));
  if (!is_joined_) UnpublishedStore::check(call.store, call.options.existing);
}

/// A store in one piece has another UUID than one in shards, because its files are others; each
/// join of the plan gives it the same one.
StoreUuid SubdivisionWork::uuid_of_result(const JoinOptions& options) const {
  StoreUuid uuid = plan_.plan.uuid;
  if (!options.concat) return uuid;
  for (const std::size_t half : {0u, 8u}) {
    const std::uint64_t changed = checksum_of(uuid);
    save(std::span(uuid), half, changed);
  }
  return uuid;
}

/// Whether an earlier join has made the store at `path`. Whatever else is there is for
/// UnpublishedStore::check().
bool SubdivisionWork::is_store_of_plan(const std::filesystem::path& path,
                                       const StoreUuid& uuid) const try {
  return open_for_reading(open_store_directory(path)).manifest.uuid == uuid;
} catch (const Error&) {  // no store, or one that cannot be opened
  return false;
}

std::unique_ptr<PartBlocks> SubdivisionWork::blocks(const JoinCall& call,
                                                    const std::vector<DoneFile>& parts) {
  const RegisteredBackend& backend = call.backends.find(plan_.plan.backend);
  backend.check_machine();
  description_ = description_of(parts);
  mesh_ = read_mesh(base_);
  shards_ = shards();
  return std::make_unique<PartBlocks>(plan_, mesh_, description_, shards_, backend);
}

void SubdivisionWork::make_store(const std::filesystem::path& path,
                                 const std::vector<DoneFile>& parts,
                                 const std::function<void(std::uint32_t)>& tell) const {
  const Directory store = claim_store_directory(path, Durability::kCommit);
  VersionDescription description = description_of(parts);
  std::map<std::string, std::uint64_t> expected;
  const auto take = [&](const Directory& from, const std::string& name, std::uint64_t bytes) {
    link_or_copy(from, name, store);
    expected[name] = bytes;
  };
  const auto size_of = [](const Directory& from, const std::string& name) {
    return File(from, name, OpenMode::kRead).size();
  };
  take(directory_, kBaseMeshName, plan_.base_mesh.bytes);
  if (directory_.contains(kBaseIndexName))
    take(directory_, kBaseIndexName, size_of(directory_, kBaseIndexName));
  for (const DoneFile& done : parts) {
    tell(done.part);
    const Directory inside(directory_, done.directory);
    for (const auto& level : done.levels) take(inside, level.name, level.bytes);
    const std::string tables = tables_file_name(1, done.part);
    take(inside, tables, size_of(inside, tables));
    description.shards.push_back({plan_.plan.parts[done.part].first_edge, done.tables_checksum});
  }
  std::vector<std::size_t> record_bytes;
  for (const AttributeRecord& attribute : description.attributes)
    record_bytes.push_back(attribute.schema.record_bytes());
  StoreLock lock(store, LockFor::kCreating);
  lock.sign();
  const auto records = merge_base_records(directory_, plan_, parts, read_mesh(base_), record_bytes);
  publish_version(store, lock, plan_.plan.uuid, 1,
                  {std::move(description), {records.begin(), records.end()}, {}}, true);
  expected[version_file_name(1)] = open_newest_version(store).manifest.version_bytes;
  check_files(store, expected, "join " + directory_.path().native());
}

/// Another join of the plan may have been faster: then its store stays.
void SubdivisionWork::publish(const JoinCall& call, UnpublishedStore& output) {
  try {
    output.publish(true);
  } catch (const Error& error) {
    is_joined_ = error.code() == ErrorCode::kInvalidArgument &&
                 is_store_of_plan(call.store, plan_.plan.uuid);
    if (!is_joined_) throw;
    const Directory made(output.path());
    remove_store_files(made);
    made.remove_itself();
  }
}

void SubdivisionWork::commit(const JoinCall& call, const std::vector<DoneFile>& parts,
                             const std::string& digest,
                             const std::function<void(std::uint32_t)>& tell) {
  const JoinOptions& options = call.options;
  if (is_joined_) {
    if (options.concat || parts.empty()) return;
    std::unique_ptr<PartBlocks> all;
    mend_shards(
        directory_, plan_, call.store, parts,
        [&](const DoneFile& part) {
          if (!all) all = blocks(call, parts);
          all->read_all(directory_, part);
        },
        options.warn);
    return;
  }
  UnpublishedStore output(call.store, options.existing, options.warn);
  build_output(output, [&] {
    make_store(output.make(), parts, tell);
    if (!options.verify) return;
    OpenOptions open;
    open.budget_bytes = options.budget_bytes;
    DigestOptions how;
    how.progress = options.progress;
    if (const std::string found =
            plait::digest(Store::open(output.path(), open, call.backends), how).to_string();
        found != digest)
      throw Error(ErrorCode::kCorruption,
                  fmt::format("join {}: the parts add up to digest {}, and the store has {}",
                              call.plan.native(), digest, found));
  });
  if (!options.concat) return publish(call, output);
  ConversionRequest request;
  request.from = output.path();
  request.to = call.store;
  request.budget_bytes = options.budget_bytes;
  request.existing = options.existing;
  request.uuid = uuid_of_result(options);
  JobWatch watch;
  watch.progress = options.progress;
  watch.warn = options.warn;
  convert(request, call.backends, call.backends, watch);
}

}  // namespace

std::unique_ptr<PartWork> PartWork::of(const Directory& plan_directory, const PlanFile& plan) {
  if (plan.plan.pass) return pass_work(plan_directory, plan);
  return std::make_unique<SubdivisionWork>(plan_directory, plan);
}

PLAIT_END_NAMESPACE
