#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "conversion/conversion_job.h"
#include "execution/part_digest.h"
#include "format/base_mesh_file.h"
#include "format/checksum.h"
#include "format/file_names.h"
#include "parts/base_records.h"
#include "parts/done_file.h"
#include "parts/join_pass.h"
#include "parts/link_or_copy.h"
#include "parts/part_blocks.h"
#include "parts/plan_file.h"
#include "parts/sealed_file.h"
#include "plait/error.h"
#include "plait/extend/file.h"
#include "plait/extend/parts.h"
#include "store/lock.h"
#include "store/recovery.h"
#include "store/unpublished_store.h"
#include "store/version_writer.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

class Join {
 public:
  Join(const std::filesystem::path& path, const JoinOptions& options)
      : path_(path),
        options_(options),
        directory_(open_plan_directory(path)),
        plan_(read_plan_file(directory_)) {
    if (plan_.plan.pass) return;
    base_ = File(directory_, kBaseMeshName, OpenMode::kRead);
    refuse_hole(base_);
    if (base_.size() != plan_.base_mesh.bytes || checksum_of(base_) != plan_.base_mesh.checksum)
      throw Error(ErrorCode::kCorruption, fmt::format("join {}: {} is not that of the plan",
                                                      path.native(), base_.path().native()))
          .about(base_.path());
  }

  const PlanFile& plan() const { return plan_; }

  /// Finds what is missing or bad. `description` is what done files have, if that is known.
  void look_at_parts(JoinResult& result, std::span<const std::byte> description = {}) {
    Digest sum;
    for (std::uint32_t part = 0; part < plan_.plan.parts.size(); ++part) {
      tell("parts", part);
      try {
        std::optional<DoneFile> done = read_done_part(directory_, plan_, part);
        if (!done) {
          result.missing.push_back(part);
          continue;
        }
        if (!description.empty() && !std::ranges::equal(done->description, description))
          throw Error(ErrorCode::kCorruption,
                      fmt::format("open {}: the part makes another version than the plan",
                                  directory_.path_of(done_file_name(part)).native()));
        if (!parts_.empty() && done->description != parts_.front().description)
          throw Error(
              ErrorCode::kCorruption,
              fmt::format("open {}: another program or other options made it than part {}",
                          directory_.path_of(done_file_name(part)).native(), parts_.front().part));
        sum = sum_of(sum, done->digest);
        if (!parts_.empty()) done->description = {};  // equal to that of the first
        parts_.push_back(std::move(*done));
      } catch (const Error& error) {
        if (error.code() != ErrorCode::kCorruption && error.code() != ErrorCode::kNotFound &&
            error.code() != ErrorCode::kNotSupported && error.code() != ErrorCode::kIo)
          throw;
        bad(result, part, error.what());
      }
    }
    result.digest = sum.to_string();
  }

  /// How many directories no done.I names: of parts that were killed on another machine, or that
  /// still run there.
  std::size_t other_directories() const {
    std::set<std::string> named;
    for (const DoneFile& done : parts_) named.insert(done.directory);
    return static_cast<std::size_t>(
        std::ranges::count_if(directory_.names(), [&](const std::string& name) {
          return name.starts_with("part.") && !named.contains(name);
        }));
  }

  /// Makes the store in the empty directory `path`.
  void make_store(const std::filesystem::path& path) {
    const Directory store = claim_store_directory(path, Durability::kCommit);
    VersionDescription description =
        decode_description(parts_.front().description, 1, directory_.path());
    link_or_copy(directory_, kBaseMeshName, store);
    for (const DoneFile& done : parts_) {
      tell("files", done.part);
      const Directory inside(directory_, done.directory);
      for (const auto& level : done.levels) link_or_copy(inside, level.name, store);
      link_or_copy(inside, tables_file_name(1, done.part), store);
      description.shards.push_back({plan_.plan.parts[done.part].first_edge, done.tables_checksum});
    }
    const BaseMesh mesh = read_base_mesh();
    std::vector<std::size_t> record_bytes;
    for (const AttributeRecord& attribute : description.attributes)
      record_bytes.push_back(attribute.schema.record_bytes());
    StoreLock lock(store, LockFor::kCreating);
    lock.sign();
    const auto records = merge_base_records(directory_, plan_, parts_, mesh, record_bytes);
    publish_version(store, lock, plan_.plan.uuid, 1,
                    {std::move(description), {records.begin(), records.end()}, {}}, true);
  }

  /// Makes the parts of a pass the next version of the store.
  void commit_pass(const std::filesystem::path& path, const BackendRegistry& backends,
                   JoinResult& result) {
    const PassTarget target(path, plan_, path_);
    look_at_parts(result, target.description_seal());
    if (options_.verify && !target.is_later()) verify_parts(target.blocks(backends), result);
    if (!result.missing.empty() || !result.bad.empty()) return;
    if (target.is_later()) {
      if (!target.is_made_of(parts_))
        throw Error(ErrorCode::kBadState,
                    fmt::format("join {}: {} has version {} of another plan already",
                                path_.native(), path.native(), plan_.version()));
      return;
    }
    target.commit(directory_, parts_, [&](std::uint32_t part) { tell("files", part); });
  }

  /// Reads every block of the parts of a subdivision that are there.
  void verify_parts(const BackendRegistry& backends, JoinResult& result) {
    if (parts_.empty()) return;
    const VersionDescription description =
        decode_description(parts_.front().description, 1, directory_.path());
    const RegisteredBackend& backend = backends.find(plan_.plan.backend);
    backend.check_machine();
    const EdgeShards shards(plan_.starts(), plan_.edge_count);
    const BaseMesh mesh = read_base_mesh();
    verify_parts(PartBlocks(plan_, mesh, description, shards, backend), result);
  }

  /// Compares the records of the store with the digests of the parts.
  void compare_digest(const std::filesystem::path& path, const BackendRegistry& backends,
                      const JoinResult& result) const {
    OpenOptions open;
    open.budget_bytes = options_.budget_bytes;
    DigestOptions how;
    how.progress = options_.progress;
    if (const std::string found = digest(Store::open(path, open, backends), how).to_string();
        found != result.digest)
      throw Error(ErrorCode::kCorruption,
                  fmt::format("join {}: the parts add up to digest {}, and the store has {}",
                              path_.native(), result.digest, found));
  }

 private:
  BaseMesh read_base_mesh() const {
    BaseMesh mesh =
        read_base_mesh_file(base_, plan_.base_mesh, plan_.vertex_count, plan_.face_count);
    if (mesh.edge_count() != plan_.edge_count)
      throw Error(ErrorCode::kCorruption,
                  fmt::format("join {}: expected {} edges, found {}", path_.native(),
                              plan_.edge_count, mesh.edge_count()));
    return mesh;
  }
  void verify_parts(const PartBlocks& blocks, JoinResult& result) const {
    for (const DoneFile& done : parts_) {
      tell("verify", done.part);
      try {
        blocks.read_all(directory_, done);
      } catch (const Error& error) {
        if (error.code() != ErrorCode::kCorruption && error.code() != ErrorCode::kIo) throw;
        bad(result, done.part, error.what());
      }
    }
  }
  static void bad(JoinResult& result, std::uint32_t part, std::string reason) {
    const auto at = std::ranges::lower_bound(result.bad, part);
    result.reasons.insert(result.reasons.begin() + (at - result.bad.begin()), std::move(reason));
    result.bad.insert(at, part);
  }
  void tell(const char* phase, std::uint32_t part) const {
    if (options_.progress && !options_.progress({phase, part, plan_.plan.parts.size()}))
      throw Error(ErrorCode::kCancelled, fmt::format("join {}: cancelled", path_.native()));
  }

  const std::filesystem::path& path_;
  const JoinOptions& options_;
  Directory directory_;
  PlanFile plan_;
  File base_;
  std::vector<DoneFile> parts_;
};

}  // namespace

std::string array_text(std::span<const std::uint32_t> numbers) {
  std::string text;
  for (std::size_t at = 0; at < numbers.size();) {
    std::size_t end = at + 1;
    while (end < numbers.size() && numbers[end] == numbers[end - 1] + 1) ++end;
    // Sums of texts would be shorter, but GCC 12 warns of them in vain (-Wrestrict).
    if (!text.empty()) text += ',';
    text += std::to_string(numbers[at]);
    if (end - at > 1) text.append(1, '-').append(std::to_string(numbers[end - 1]));
    at = end;
  }
  return text;
}

std::string JoinResult::again() const {
  std::vector<std::uint32_t> all;
  std::ranges::merge(missing, bad, std::back_inserter(all));
  return array_text(all);
}

JoinResult join_parts(const std::filesystem::path& plan, const std::filesystem::path& store,
                      const JoinOptions& options, const BackendRegistry& backends) try {
  const auto warn = [&](const std::string& text) {
    if (options.warn) options.warn(text);
  };
  const auto tell_of_others = [&](const Join& join) {
    if (const std::size_t others = join.other_directories())
      warn(
          fmt::format("{} also has directories of parts that were killed, or that still run on "
                      "another machine: {}; the store does not need the plan any more",
                      plan.native(), others));
  };
  JoinResult result;
  Join join(plan, options);
  result.version = join.plan().version();
  if (join.plan().plan.pass) {
    if (options.concat || options.replace)
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("join {}: a pass changes its own store, which stays in shards; plait "
                              "convert makes one in one piece",
                              plan.native()));
    join.commit_pass(store, backends, result);
    result.has_store = result.missing.empty() && result.bad.empty();
    if (result.has_store) tell_of_others(join);
    return result;
  }
  const Existing existing = options.replace ? Existing::kReplace : Existing::kRefuse;
  UnpublishedStore::check(store, existing);
  join.look_at_parts(result);
  if (options.verify) join.verify_parts(backends, result);
  if (!result.missing.empty() || !result.bad.empty()) return result;
  UnpublishedStore output(store, existing, options.warn);
  build_output(output, [&] {
    join.make_store(output.make());
    if (options.verify) join.compare_digest(output.path(), backends, result);
  });
  if (options.concat) {
    ConversionRequest request;
    request.from = output.path();
    request.to = store;
    request.budget_bytes = options.budget_bytes;
    request.replace = options.replace;
    JobWatch watch;
    watch.progress = options.progress;
    watch.warn = options.warn;
    convert(request, backends, backends, watch);
  } else {
    output.publish(true);
  }
  tell_of_others(join);
  result.has_store = true;
  return result;
} catch (const std::bad_alloc&) {
  throw out_of_memory("join " + plan.native());
}

PLAIT_END_NAMESPACE
