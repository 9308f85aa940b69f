#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "base/stopwatch.h"
#include "execution/part_digest.h"
#include "format/file_names.h"
#include "format/version_description.h"
#include "job_rules.h"
#include "parts/base_records.h"
#include "parts/files_of_parts.h"
#include "parts/link_or_copy.h"
#include "parts/part_work.h"
#include "parts/pass_result.h"
#include "plait/error.h"
#include "plait/extend/file.h"
#include "plait/extend/store_access.h"
#include "store/lock.h"
#include "store/recovery.h"
#include "store/stored_version.h"
#include "store/version_writer.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

std::uint32_t level_count_of(const VersionDescription& description) {
  std::size_t count = 0;
  for (const AttributeRecord& attribute : description.attributes) count += attribute.levels.size();
  return static_cast<std::uint32_t>(count);
}

/// Throws unless the plan's pass reads this version: then the plan's counts and cuts are those of
/// the store. Returns the description of the next version, as version_after(). `path` is that of
/// the plan. Errors: kBadState for another store, another version and a copy that went its own way;
/// kCorruption for a plan that says other things than the store.
VersionDescription check_pass_fits(const PlanFile& plan, const StoredVersion& version,
                                   const std::filesystem::path& path) {
  const PlannedPass& planned = *plan.plan.pass;
  const Manifest& manifest = version.manifest();
  if (manifest.uuid != plan.plan.uuid)
    throw Error(ErrorCode::kBadState,
                fmt::format("pass {}: expected the store that the plan was made of, found another "
                            "one with {}",
                            path.native(), version.version_name()));
  if (manifest.sequence != planned.version)
    throw Error(ErrorCode::kBadState,
                fmt::format("pass {}: expected version {} of the store, found version {}: the plan "
                            "is done or out of date, make a new one",
                            path.native(), planned.version, manifest.sequence));
  if (manifest.version_checksum != planned.version_checksum)
    throw Error(
        ErrorCode::kBadState,
        fmt::format("pass {}: expected version {} with checksum {:016x}, found a version {} "
                    "with checksum {:016x}: a copy of the store that went its own way",
                    path.native(), planned.version, planned.version_checksum, manifest.sequence,
                    manifest.version_checksum));
  const VersionDescription& description = version.description();
  const auto require = [&](std::string_view what, const auto& expected, const auto& found) {
    if (expected != found)
      throw Error(ErrorCode::kCorruption,
                  fmt::format("pass {}: {}: the store has {}, the plan says {}", path.native(),
                              what, expected, found));
  };
  require("vertices", description.vertex_count, plan.vertex_count);
  require("edges", description.edge_count, plan.edge_count);
  require("faces", description.face_count, plan.face_count);
  require("base level", description.provenance.base_level, plan.plan.base_level);
  require("parts", description.shards.size(), plan.plan.parts.size());
  require("files of several levels", description.shares_files, plan.shares_files);
  for (std::size_t at = 0; at < description.shards.size(); ++at)
    require("first edge of a part", description.shards[at].first_edge,
            plan.plan.parts[at].first_edge);
  VersionDescription next;
  try {
    next = version_after(description, planned.pass, plan.version(), plan.plan.program);
  } catch (const Error& error) {
    throw Error(ErrorCode::kCorruption, fmt::format("pass {}: {}", path.native(), error.what()));
  }
  const auto made =
      std::ranges::find(next.attributes, plan.of_pass.attribute_number, &AttributeRecord::number);
  require("the number of the result", description.next_attribute_number,
          plan.of_pass.attribute_number);
  if (made->schema != planned.result)
    throw Error(ErrorCode::kCorruption,
                fmt::format("pass {}: expected the attribute '{}' as result, found '{}'",
                            path.native(), made->schema.name, planned.result.name));
  require("finest level", next.finest_level(*made), plan.plan.levels);
  require("levels", level_count_of(next), plan.of_pass.level_count);
  return next;
}

StoreLock lock_of_plan(const Directory& store, const PlanFile& plan,
                       const std::filesystem::path& path) {
  // Another store stays as it is, also its lock file.
  if (open_newest_version(store).manifest.uuid != plan.plan.uuid)
    throw Error(ErrorCode::kBadState,
                fmt::format("join {}: {} is another store than that of the plan", path.native(),
                            store.path().native()));
  return lock_for_writing(store, Durability::kCommit);
}

/// The version of the store that a join finds, and the one that it makes.
struct JoinedPass {
  JoinedPass(const JoinCall& call, const PlanFile& plan)
      : store(open_store_directory(call.store)),
        lock(lock_of_plan(store, plan, call.plan)),
        version(store, open_newest_version(store)),
        is_later(version.manifest().sequence == plan.version()) {
    if (is_later) return;
    next = check_pass_fits(plan, version, call.plan);
    seal = seal_of(encode_description(next));
    mesh = version.read_base_mesh();
    shards = version.shards();
  }

  Directory store;
  StoreLock lock;
  StoredVersion version;
  bool is_later;  ///< the store has the version that the pass makes, or another one in its place
  VersionDescription next;
  std::vector<std::byte> seal;
  BaseMesh mesh;
  EdgeShards shards;
};

class PassWork : public PartWork {
 public:
  PassWork(const Directory& plan_directory, const PlanFile& plan)
      : PartWork(plan_directory, plan) {}

  ComputedPart compute(std::uint32_t part, const Directory& directory, const PartOptions& options,
                       const BackendRegistry& backends) const override;
  void check(const JoinCall& call) override;
  bool is_joined() const override { return joined_->is_later; }
  std::span<const std::byte> description() const override { return joined_->seal; }
  std::unique_ptr<PartBlocks> blocks(const JoinCall& call,
                                     const std::vector<DoneFile>& parts) override;
  void commit(const JoinCall& call, const std::vector<DoneFile>& parts, const std::string& digest,
              const std::function<void(std::size_t)>& tell) override;

 private:
  std::optional<JoinedPass> joined_;
};

ComputedPart PassWork::compute(std::uint32_t part, const Directory& directory,
                               const PartOptions& options, const BackendRegistry& backends) const {
  const PlannedPass& planned = *plan_.plan.pass;
  const std::filesystem::path& path = options.store.empty() ? planned.store : options.store;
  ComputedPart computed;
  const Stopwatch clock;
  PartOfVersion of;
  of.shard = part;
  of.directory = directory.path();
  of.check = [&](const StoredVersion& version) {
    check_pass_fits(plan_, version, directory_.path());
  };
  OpenOptions open;
  open.budget_bytes = options.budget_bytes;
  open.parallel_for = options.parallel_for;
  Store store = [&] {
    try {
      return open_part_store(path, of, open, backends);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kNotFound || !options.store.empty()) throw;
      throw Error(error.code(),
                  fmt::format("{}; plait part --store names another path to it", error.what()))
          .about(path);
    }
  }();
  computed.begin_seconds = clock.seconds();
  Pass pass = planned.pass;
  pass.kernel = options.kernel;
  VisitOptions visit;
  visit.threads = options.threads;
  visit.begins = [&](int threads) {
    warn_of_fewer_threads(fmt::format("part {}", part), threads, options.threads,
                          options.budget_bytes, options.warn);
  };
  visit.progress = options.progress;
  PassFigures figures;
  const AttributeId result = make_result(store, pass, visit, figures);
  const double visited = clock.seconds();
  computed.content = finish_part_store(store);
  computed.description = seal_of(encode_description(computed.content.description));
  const double written = clock.seconds();
  computed.digest = digest_of_part(store, *StoreAccess::own_vertices(store), std::array{result},
                                   options.progress);
  store.close();
  computed.write_seconds = written - visited;
  computed.compute_seconds = clock.seconds() - computed.write_seconds - computed.begin_seconds;
  return computed;
}

void PassWork::check(const JoinCall& call) {
  if (call.options.concat || call.options.existing == Existing::kReplace)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("join {}: a pass changes its own store, which stays in shards; plait "
                            "convert makes one in one piece",
                            call.plan.native()));
  joined_.emplace(call, plan_);
  const auto missing = missing_protection(joined_->lock, joined_->store);
  if (missing && !is_joined() && call.options.warn) call.options.warn(*missing);
}

std::unique_ptr<PartBlocks> PassWork::blocks(const JoinCall& call, const std::vector<DoneFile>&) {
  return std::make_unique<PartBlocks>(plan_, joined_->mesh, joined_->next, joined_->shards,
                                      joined_->version.find_backend(call.backends));
}

void PassWork::commit(const JoinCall& call, const std::vector<DoneFile>& parts, const std::string&,
                      const std::function<void(std::size_t)>& tell) {
  const Directory& store = joined_->store;
  const StoredVersion& version = joined_->version;
  if (joined_->is_later) {
    if (!std::ranges::equal(parts, version.description().shards, {}, &DoneFile::tables_checksum,
                            &ShardRecord::tables_checksum))
      throw Error(ErrorCode::kBadState,
                  fmt::format("join {}: {} has version {} of another plan already",
                              call.plan.native(), call.store.native(), plan_.version()));
    return;
  }
  std::vector<ZeroedArray<std::byte>> records;
  std::vector<std::vector<std::byte>> faces;
  for (const AttributeRecord& attribute : joined_->next.attributes)
    records.push_back(attribute.number == plan_.of_pass.attribute_number
                          ? std::move(merge_base_records(directory_, plan_, parts, joined_->mesh,
                                                         {attribute.schema.record_bytes()})
                                          .front())
                          : version.read_base_records(attribute, joined_->mesh));
  for (const FaceAttributeRecord& attribute : joined_->next.face_attributes)
    faces.push_back(version.read_face_records(attribute));
  VersionDescription description = joined_->next;
  std::vector<ExpectedFile> expected;
  give_files_of_parts(directory_, parts, plan_.version(), store, give_name, tell, expected);
  for (const DoneFile& done : parts)
    description.shards.push_back({plan_.plan.parts[done.part].first_edge, done.tables_checksum});
  check_files(store, expected, "join " + call.plan.native());
  publish_version(
      store, joined_->lock, plan_.plan.uuid, plan_.version(),
      {std::move(description), {records.begin(), records.end()}, {faces.begin(), faces.end()}},
      true);
  try {
    remove_old_versions(store);
  } catch (const Error&) {  // the version is committed; the next writer removes the files
  }
}

}  // namespace

std::unique_ptr<PartWork> pass_work(const Directory& plan_directory, const PlanFile& plan) {
  return std::make_unique<PassWork>(plan_directory, plan);
}

PLAIT_END_NAMESPACE
