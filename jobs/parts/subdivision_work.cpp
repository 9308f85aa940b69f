#include <fmt/format.h>

#include <numeric>
#include <utility>
#include <vector>

#include "base/stopwatch.h"
#include "conversion/conversion_job.h"
#include "execution/part_digest.h"
#include "format/base_index_file.h"
#include "format/base_mesh_file.h"
#include "format/checksum.h"
#include "format/file_names.h"
#include "parts/base_records.h"
#include "parts/link_or_copy.h"
#include "parts/part_work.h"
#include "parts/sealed_file.h"
#include "plait/error.h"
#include "plait/extend/file.h"
#include "plait/subdivide.h"
#include "store/lock.h"
#include "store/recovery.h"
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
  void check(const JoinCall& call) override;
  bool is_joined() const override { return is_joined_; }
  std::unique_ptr<PartBlocks> blocks(const JoinCall& call,
                                     const std::vector<DoneFile>& parts) override;
  void commit(const JoinCall& call, const std::vector<DoneFile>& parts, const std::string& digest,
              const std::function<void(std::uint32_t)>& tell) override;

 private:
  EdgeShards shards() const { return {plan_.starts(), plan_.edge_count}; }
  VersionDescription description_of(const std::vector<DoneFile>& parts) const {
    return decode_description(parts.front().description, 1, directory_.path());
  }
  BaseMesh read_mesh(const File& file) const;
  Store create_store(std::uint32_t part, const Directory& directory, const PartOptions& options,
                     const BackendRegistry& backends) const;
  void make_store(const std::filesystem::path& path, const std::vector<DoneFile>& parts,
                  const std::function<void(std::uint32_t)>& tell) const;
  bool is_store_of_plan(const std::filesystem::path& path) const;

  // For a join.
  bool is_joined_ = false;
  File base_;
  BaseMesh mesh_;
  VersionDescription description_;
  EdgeShards shards_;
};

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

Store SubdivisionWork::create_store(std::uint32_t part, const Directory& directory,
                                    const PartOptions& options,
                                    const BackendRegistry& backends) const {
  const File base(directory_, kBaseMeshName, OpenMode::kRead);
  refuse_hole(base);
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
  return create_part_store(directory.path(), read_mesh(base), store, backends,
                           {.layout = plan_.layout, .base_level = plan_.plan.base_level},
                           {plan_.plan.uuid, shards(), part, plan_.base_mesh});
}

ComputedPart SubdivisionWork::compute(std::uint32_t part, const Directory& directory,
                                      const PartOptions& options,
                                      const BackendRegistry& backends) const {
  ComputedPart computed;
  const Stopwatch clock;
  Store store = create_store(part, directory, options, backends);
  add_base_positions(store, plan_.precision);
  computed.begin_seconds = clock.seconds();
  SubdivideOptions subdivision;
  subdivision.scheme = scheme_from_name(plan_.scheme);
  subdivision.levels = plan_.plan.levels;
  subdivision.normals = plan_.normals;
  subdivision.limit = plan_.limit;
  subdivision.executor = ExecutorKind::kFused;
  subdivision.threads = options.threads;
  subdivision.progress = options.progress;
  subdivide(store, subdivision);
  const double refined = clock.seconds();
  computed.content = finish_part_store(store);
  computed.description = encode_description(computed.content.description);
  const double written = clock.seconds();
  std::vector<AttributeId> all(store.attributes().size());
  std::iota(all.begin(), all.end(), 0);
  computed.digest = digest_of_part(store, owned_vertices(store.base().topology(), shards(), part),
                                   all, options.progress);
  store.close();
  computed.write_seconds = written - refined;
  computed.compute_seconds = clock.seconds() - computed.write_seconds - computed.begin_seconds;
  return computed;
}

void SubdivisionWork::check(const JoinCall& call) {
  base_ = File(directory_, kBaseMeshName, OpenMode::kRead);
  refuse_hole(base_);
  if (base_.size() != plan_.base_mesh.bytes || checksum_of(base_) != plan_.base_mesh.checksum)
    throw Error(ErrorCode::kCorruption, fmt::format("join {}: {} is not that of the plan",
                                                    call.plan.native(), base_.path().native()))
        .about(base_.path());
  is_joined_ = call.options.existing == Existing::kRefuse && is_store_of_plan(call.store);
  if (!is_joined_) UnpublishedStore::check(call.store, call.options.existing);
}

/// Whether an earlier join has made the store at `path`. Whatever else is there is for
/// UnpublishedStore::check().
bool SubdivisionWork::is_store_of_plan(const std::filesystem::path& path) const try {
  return open_for_reading(open_store_directory(path)).manifest.uuid == plan_.plan.uuid;
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
  link_or_copy(directory_, kBaseMeshName, store);
  if (directory_.contains(kBaseIndexName)) link_or_copy(directory_, kBaseIndexName, store);
  for (const DoneFile& done : parts) {
    tell(done.part);
    const Directory inside(directory_, done.directory);
    for (const auto& level : done.levels) link_or_copy(inside, level.name, store);
    link_or_copy(inside, tables_file_name(1, done.part), store);
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
}

void SubdivisionWork::commit(const JoinCall& call, const std::vector<DoneFile>& parts,
                             const std::string& digest,
                             const std::function<void(std::uint32_t)>& tell) {
  if (is_joined_) return;
  const JoinOptions& options = call.options;
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
  if (!options.concat) return output.publish(true);
  ConversionRequest request;
  request.from = output.path();
  request.to = call.store;
  request.budget_bytes = options.budget_bytes;
  request.existing = options.existing;
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
