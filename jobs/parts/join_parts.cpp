#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "execution/part_digest.h"
#include "parts/done_file.h"
#include "parts/files_at_once.h"
#include "parts/part_blocks.h"
#include "parts/part_work.h"
#include "parts/plan_file.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/extend/parts.h"
#include "plait/store.h"
#include "plait/verify.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

class Join {
 public:
  Join(const Directory& directory, const PlanFile& plan, const JoinCall& call)
      : directory_(directory), plan_(plan), call_(call) {}

  const std::vector<DoneFile>& parts() const { return parts_; }

  /// Finds what is missing or bad. `description` is what done files have; empty if that is not
  /// known.
  void look_at_parts(JoinResult& result, std::span<const std::byte> description) {
    constexpr std::size_t kPartsInMemory = 1024;  // with a description each
    const std::size_t count = plan_.plan.parts.size();
    Digest sum;
    for (std::size_t first = 0; first < count; first += kPartsInMemory) {
      std::vector<Found> found(std::min(kPartsInMemory, count - first));
      each_file_at_once(
          found.size(), "a join",
          [&](std::size_t at) { found[at] = find(static_cast<std::uint32_t>(first + at)); },
          [&](std::size_t begun) { tell("parts", first + begun); });
      for (std::size_t at = 0; at < found.size(); ++at)
        take(std::move(found[at]), static_cast<std::uint32_t>(first + at), description, result,
             sum);
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

  /// Whether a part was made again since look_at_parts(): then its files were removed.
  bool is_out_of_date() const {
    return std::ranges::any_of(parts_, [&](const DoneFile& done) {
      try {
        const std::optional<DoneFile> now = read_done_part(directory_, plan_, done.part);
        return now && now->directory != done.directory;
      } catch (const Error&) {
        return false;
      }
    });
  }

  /// Reads every block of the parts that are there.
  void verify(const PartBlocks& blocks, JoinResult& result) const {
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
  void tell(const char* phase, std::size_t part) const {
    const ProgressCallback& progress = call_.options.progress;
    if (progress && !progress({phase, part, plan_.plan.parts.size()}))
      throw Error(ErrorCode::kCancelled, fmt::format("join {}: cancelled", call_.plan.native()));
  }

 private:
  /// A part that is done, or why it is bad; neither if it is missing.
  struct Found {
    std::optional<DoneFile> done;
    std::optional<std::string> fault;
  };

  Found find(std::uint32_t part) const try {
    return {read_done_part(directory_, plan_, part), {}};
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kCorruption && error.code() != ErrorCode::kNotFound &&
        error.code() != ErrorCode::kNotSupported && error.code() != ErrorCode::kIo)
      throw;
    return {{}, error.what()};
  }

  void take(Found found, std::uint32_t part, std::span<const std::byte> description,
            JoinResult& result, Digest& sum) {
    if (found.fault) return bad(result, part, std::move(*found.fault));
    if (!found.done) return result.missing.push_back(part);
    DoneFile& done = *found.done;
    const auto name = [&] { return directory_.path_of(done_file_name(part)).native(); };
    if (!description.empty() && !std::ranges::equal(done.description, description))
      return bad(result, part,
                 fmt::format("open {}: the part makes another version than the plan", name()));
    if (!parts_.empty() && done.description != parts_.front().description)
      return bad(result, part,
                 fmt::format("open {}: another program or other options made it than part {}",
                             name(), parts_.front().part));
    sum = sum_of(sum, done.digest);
    if (!parts_.empty()) done.description = {};  // equal to that of the first
    parts_.push_back(std::move(done));
  }

  static void bad(JoinResult& result, std::uint32_t part, std::string reason) {
    const auto at = std::ranges::lower_bound(result.bad, part);
    result.reasons.insert(result.reasons.begin() + (at - result.bad.begin()), std::move(reason));
    result.bad.insert(at, part);
  }

  const Directory& directory_;
  const PlanFile& plan_;
  const JoinCall& call_;
  std::vector<DoneFile> parts_;
};

/// Reads every block of a store that an earlier join has made. Sets a digest that is not known.
void verify_joined(const JoinCall& call, JoinResult& result) {
  OpenOptions open;
  open.budget_bytes = call.options.budget_bytes;
  Store store = Store::open(call.store, open, call.backends);
  const VerifyReport report = verify(store, call.options.progress);
  if (report.damaged_count == 0) {
    DigestOptions how;
    how.progress = call.options.progress;
    if (result.digest.empty()) result.digest = digest(store, how).to_string();
    return;
  }
  const DamagedBlock& first = report.damaged.front();
  throw Error(ErrorCode::kCorruption,
              fmt::format("join {}: {} was joined before and has {} damaged blocks, the first in "
                          "{} at level {}: {}",
                          call.plan.native(), call.store.native(), report.damaged_count,
                          first.attribute, first.level, first.reason));
}

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

namespace {

JoinResult try_join(const Directory& directory, const PlanFile& plan, const JoinCall& call,
                    Join& join) {
  const JoinOptions& options = call.options;
  const std::unique_ptr<PartWork> work = PartWork::of(directory, plan);
  JoinResult result;
  result.version = plan.version();
  work->check(call);
  join.look_at_parts(result, work->description());
  if (options.verify && !work->is_joined() && !join.parts().empty())
    join.verify(*work->blocks(call, join.parts()), result);
  if (!result.bad.empty() && join.is_out_of_date())
    throw Error(ErrorCode::kBusy,
                fmt::format("join {}: other processes make parts again", call.plan.native()));
  if (!work->needs_all_parts() && !result.missing.empty()) {
    result.missing.clear();
    result.digest.clear();
  }
  if (!result.missing.empty() || !result.bad.empty()) return result;
  work->commit(call, join.parts(), result.digest,
               [&](std::size_t begun) { join.tell("files", begun); });
  if (options.verify && work->is_joined()) verify_joined(call, result);
  if (const std::size_t others = join.other_directories(); others > 0 && options.warn)
    options.warn(
        fmt::format("{} also has directories of parts that were killed, or that still run on "
                    "another machine: {}; the store does not need the plan any more",
                    call.plan.native(), others));
  result.has_store = true;
  result.was_joined = work->is_joined();
  return result;
}

}  // namespace

JoinResult join_parts(const std::filesystem::path& path, const std::filesystem::path& store,
                      const JoinOptions& options, const BackendRegistry& backends) try {
  const Directory directory = open_plan_directory(path);
  const PlanFile plan = read_plan_file(directory);
  const JoinCall call{path, store, options, backends};
  for (int attempt = 1;; ++attempt) {
    Join join(directory, plan, call);
    try {
      return try_join(directory, plan, call, join);
    } catch (const Error& error) {
      if (attempt == kMostReplacements || error.code() == ErrorCode::kCancelled ||
          !join.is_out_of_date())
        throw;
    }
  }
} catch (const std::bad_alloc&) {
  throw out_of_memory("join " + path.native());
}

PLAIT_END_NAMESPACE
