#include "parts/join_pass.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "format/file_names.h"
#include "parts/base_records.h"
#include "parts/link_or_copy.h"
#include "parts/pass_store.h"
#include "plait/error.h"
#include "plait/extend/block_maker.h"
#include "store/recovery.h"
#include "store/version_writer.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

StoreLock lock_of_plan(const Directory& store, const PlanFile& plan,
                       const std::filesystem::path& path) {
  // Another store stays as it is, also its lock file.
  if (open_newest_version(store).manifest.uuid != plan.plan.uuid)
    throw Error(ErrorCode::kBadState,
                fmt::format("join {}: {} is another store than that of the plan", path.native(),
                            store.path().native()));
  return lock_for_writing(store, Durability::kCommit);
}

}  // namespace

PassTarget::PassTarget(const std::filesystem::path& store, const PlanFile& plan,
                       const std::filesystem::path& path)
    : plan_(plan),
      store_(open_store_directory(store)),
      lock_(lock_of_plan(store_, plan, path)),
      version_(store_, open_newest_version(store_)) {
  if (is_later()) return;
  next_ = check_pass_fits(plan_, version_, path);
  seal_ = seal_of(encode_description(next_));
  mesh_ = version_.read_base_mesh();
  shards_ = version_.shards();
}

bool PassTarget::is_made_of(const std::vector<DoneFile>& parts) const {
  return std::ranges::equal(parts, version_.description().shards, {}, &DoneFile::tables_checksum,
                            &ShardRecord::tables_checksum);
}

PartBlocks PassTarget::blocks(const BackendRegistry& backends) const {
  return {plan_, mesh_, next_, shards_, version_.find_backend(backends)};
}

void PassTarget::commit(const Directory& plan_directory, const std::vector<DoneFile>& parts,
                        const std::function<void(std::uint32_t)>& tell) const {
  std::vector<std::vector<std::byte>> records, faces;
  for (const AttributeRecord& attribute : next_.attributes)
    records.push_back(attribute.number == plan_.of_pass.attribute_number
                          ? merge_base_records(plan_directory, plan_, parts, mesh_,
                                               {attribute.schema.record_bytes()})
                                .front()
                          : version_.read_base_records(attribute));
  for (const FaceAttributeRecord& attribute : next_.face_attributes)
    faces.push_back(version_.read_face_records(attribute));
  VersionDescription description = next_;
  // A join that was killed may have left some of these names.
  const auto give_name = [&](const Directory& inside, const std::string& name) {
    store_.remove(name);
    link_or_copy(inside, name, store_);
  };
  for (const DoneFile& done : parts) {
    tell(done.part);
    const Directory inside(plan_directory, done.directory);
    for (const auto& level : done.levels) give_name(inside, level.name);
    give_name(inside, tables_file_name(plan_.version(), done.part));
    description.shards.push_back({plan_.plan.parts[done.part].first_edge, done.tables_checksum});
  }
  publish_version(
      store_, lock_, plan_.plan.uuid, plan_.version(),
      {std::move(description), {records.begin(), records.end()}, {faces.begin(), faces.end()}},
      true);
  try {
    remove_old_versions(store_);
  } catch (const Error&) {  // the version is committed; the next writer removes the files
  }
}

PLAIT_END_NAMESPACE
