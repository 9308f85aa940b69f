#include "parts/mend_shards.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <utility>

#include "format/file_names.h"
#include "format/version_description.h"
#include "io/unpublished.h"
#include "maintenance/repair_files.h"
#include "parts/link_or_copy.h"
#include "parts/moved_blocks.h"
#include "plait/error.h"
#include "plait/extend/base_relative_level.h"
#include "plait/extend/file.h"
#include "store/left_overs.h"
#include "store/parts/shard_place.h"
#include "store/parts/shard_tables.h"
#include "store/recovery.h"
#include "store/stored_version.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

bool have_same_bytes(const File& one, const File& other) {
  constexpr std::uint64_t kChunk = 1u << 20;
  if (one.size() != other.size()) return false;
  std::vector<std::byte> left(kChunk), right(kChunk);
  for (std::uint64_t at = 0; at < one.size(); at += kChunk) {
    const std::size_t bytes = std::min(kChunk, one.size() - at);
    one.read_at(at, std::span(left).first(bytes));
    other.read_at(at, std::span(right).first(bytes));
    if (std::memcmp(left.data(), right.data(), bytes) != 0) return false;
  }
  return true;
}

timespec changed(const File& file) {
  struct stat status {};
  ::fstat(file.descriptor(), &status);
  return status.st_mtim;
}

/// False also if the file of the store cannot be read. A copy that is younger than the part is the
/// same without a look at its bytes: the part was not made again.
bool is_same(const Directory& store, const Directory& part, const std::string& name) try {
  const File made(part, name, OpenMode::kRead);
  if (!store.contains(name)) return false;
  if (store.contains(name, made.descriptor())) return true;
  const File there(store, name, OpenMode::kRead);
  const timespec of_part = changed(made), of_store = changed(there);
  const bool is_older =
      std::pair(of_part.tv_sec, of_part.tv_nsec) < std::pair(of_store.tv_sec, of_store.tv_nsec);
  return (is_older && made.size() == there.size()) || have_same_bytes(made, there);
} catch (const Error& error) {
  if (error.code() != ErrorCode::kIo && error.code() != ErrorCode::kCorruption) throw;
  return false;
}

class Mender {
 public:
  Mender(const Directory& plan_directory, const PlanFile& plan, const std::filesystem::path& path)
      : plan_directory_(plan_directory),
        plan_(plan),
        path_(path),
        store_(open_store_directory(path)),
        // Without a lock, because replace_file() keeps all readers out.
        version_(store_, open_newest_version(store_)),
        needed_(version_.file_names()) {
    if (version_.shard_count() != plan.plan.parts.size())
      throw Error(ErrorCode::kCorruption,
                  fmt::format("join {}: {} has {} shards, the plan {} parts",
                              plan_directory.path().native(), path.native(), version_.shard_count(),
                              plan.plan.parts.size()));
  }

  /// The names of the part's files that the store needs and has with other bytes.
  std::vector<std::string> damaged(const DoneFile& done, const Directory& inside) const {
    std::vector<std::string> names;
    const auto look_at = [&](const std::string& name) {
      if (needed_.contains(name) && !is_same(store_, inside, name)) names.push_back(name);
    };
    for (const auto& file : done.files) look_at(file.name);
    look_at(tables_file_name(1, done.part));
    return names;
  }

  /// Throws unless the store records the checksums of the part's blocks. Of the files `names`,
  /// keeps those with other blocks; the part may have the same ones in another order.
  void check(const DoneFile& done, const Directory& inside, std::vector<std::string>& names) {
    moved_.clear();
    const VersionDescription& at = version_.description();
    if (version_.manifest().sequence == 1 &&
        at.shards[done.part].tables_checksum == done.tables_checksum)
      return;
    if (!mesh_) mesh_ = version_.read_base_mesh();
    std::vector<StoredLevel> levels = version_.levels(*mesh_);
    std::vector<LevelGeometry> in_store, in_part;
    std::vector<std::pair<std::size_t, std::string>> common;  // [level of the part] in the store
    for (std::size_t number = 0; number < levels.size(); ++number) {
      in_store.push_back(levels[number].geometry.shard(done.part));
      std::string name = shard_file_name(at.shares_files, levels[number].number,
                                         levels[number].level, 1, done.part);
      if (std::ranges::find(done.files, name, &PartContent::FileOfPart::name) == done.files.end())
        continue;
      moved_[name];
      common.emplace_back(number, std::move(name));
      in_part.push_back(in_store.back());
    }
    if (moved_.size() != done.files.size()) refuse(done);
    const auto of_store = tables_of_store(done, in_store);
    const auto of_part = read_shard_tables(inside, tables_file_name(1, done.part), plan_.plan.uuid,
                                           done.part, done.tables_checksum, in_part);
    for (std::size_t number = 0; number < common.size(); ++number) {
      const auto& [level, name] = common[number];
      if (!add_blocks(of_store[level], of_part[number], moved_[name])) refuse(done);
    }
    std::erase_if(moved_, [](const auto& file) { return !are_moved(file.second); });
    std::erase_if(names, [&](const std::string& name) {
      const auto file = moved_.find(name);
      return file == moved_.end() ? name == tables_file_name(1, done.part)
                                  : have_same_blocks(store_, inside, name, file->second);
    });
  }

  void replace(const std::vector<std::string>& names, const Directory& inside) const {
    UnpublishedDirectory scratch(path_ / kRepairStem, "repair", MadeProof::kMark,
                                 remove_made_files);
    for (const std::string& name : names) {
      if (const auto file = moved_.find(name); file != moved_.end())
        write_moved(inside, name, file->second, scratch.directory());
      else
        link_or_copy(inside, name, scratch.directory());
      replace_file(path_, version_.manifest().sequence, name, scratch.directory());
    }
  }

 private:
  std::vector<std::vector<BlockEntry>> tables_of_store(const DoneFile& done,
                                                       std::span<const LevelGeometry> levels) const
      try {
    return read_shard_tables(store_, tables_file_name(version_.manifest().sequence, done.part),
                             plan_.plan.uuid, done.part,
                             version_.description().shards[done.part].tables_checksum, levels);
  } catch (const Error& error) {
    if (version_.manifest().sequence != 1 || error.code() == ErrorCode::kIo) throw;
    throw Error(error.code(),
                fmt::format("join {}: part {} has its blocks in another order than shard {} had, "
                            "whose tables are damaged: {}; make the part again (plait part "
                            "--again --threads 1)",
                            plan_directory_.path().native(), done.part, done.part, error.what()))
        .about(path_);
  }
  [[noreturn]] void refuse(const DoneFile& done) const {
    throw Error(ErrorCode::kBadState,
                fmt::format("join {}: part {} has other blocks than shard {} of {} had",
                            plan_directory_.path().native(), done.part, done.part, path_.native()));
  }

  const Directory& plan_directory_;
  const PlanFile& plan_;
  const std::filesystem::path& path_;
  const Directory store_;
  StoredVersion version_;
  const std::set<std::string> needed_;
  std::optional<BaseMesh> mesh_;
  std::map<std::string, std::vector<MovedBlock>> moved_;  ///< of the part that was checked
};

}  // namespace

void mend_shards(const Directory& plan_directory, const PlanFile& plan,
                 const std::filesystem::path& path, const std::vector<DoneFile>& parts,
                 const std::function<void(const DoneFile&)>& read_blocks,
                 const std::function<void(const std::string&)>& warn) {
  Mender mender(plan_directory, plan, path);
  for (const DoneFile& done : parts) {
    const Directory inside(plan_directory, done.directory);
    std::vector<std::string> names = mender.damaged(done, inside);
    if (names.empty()) continue;
    mender.check(done, inside, names);
    if (names.empty()) continue;
    read_blocks(done);
    mender.replace(names, inside);
    if (warn)
      warn(fmt::format("{}: shard {} had {} damaged files, which part {} of the plan has replaced",
                       path.native(), done.part, names.size(), done.part));
  }
}

PLAIT_END_NAMESPACE
