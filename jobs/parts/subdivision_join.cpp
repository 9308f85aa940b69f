#include <fmt/format.h>

#include <memory>
#include <utility>
#include <vector>

#include "conversion/conversion_job.h"
#include "format/byte_order.h"
#include "format/checksum.h"
#include "format/file_names.h"
#include "parts/base_records.h"
#include "parts/files_of_parts.h"
#include "parts/link_or_copy.h"
#include "parts/mend_shards.h"
#include "parts/subdivision_work.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "store/lock.h"
#include "store/recovery.h"
#include "store/store_directory.h"
#include "store/version_writer.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

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
                                 const std::function<void(std::size_t)>& tell) const {
  const Directory store = claim_store_directory(path, Durability::kCommit);
  VersionDescription description = description_of(parts);
  description.shares_files = plan_.shares_files;
  std::vector<ExpectedFile> expected;
  link_or_copy(directory_, kBaseMeshName, store);
  expected.push_back({kBaseMeshName, plan_.base_mesh.bytes});
  if (directory_.contains(kBaseIndexName)) {
    link_or_copy(directory_, kBaseIndexName, store);
    expected.push_back({kBaseIndexName, File(directory_, kBaseIndexName, OpenMode::kRead).size()});
  }
  give_files_of_parts(directory_, parts, 1, store, link_or_copy, tell, expected);
  for (const DoneFile& done : parts)
    description.shards.push_back({plan_.plan.parts[done.part].first_edge, done.tables_checksum});
  std::vector<std::size_t> record_bytes;
  for (const AttributeRecord& attribute : description.attributes)
    record_bytes.push_back(attribute.schema.record_bytes());
  StoreLock lock(store, LockFor::kCreating);
  lock.sign();
  const auto records = merge_base_records(directory_, plan_, parts, read_mesh(base_), record_bytes);
  publish_version(store, lock, plan_.plan.uuid, 1,
                  {std::move(description), {records.begin(), records.end()}, {}}, true);
  expected.push_back({version_file_name(1), open_newest_version(store).manifest.version_bytes});
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
                             const std::function<void(std::size_t)>& tell) {
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

PLAIT_END_NAMESPACE
