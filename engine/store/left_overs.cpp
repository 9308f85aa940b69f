#include "store/left_overs.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>

#include <algorithm>
#include <optional>

#include "base/text.h"
#include "format/file_names.h"
#include "io/made_mark.h"
#include "io/unpublished.h"
#include "plait/error.h"
#include "plait/extend/file.h"
#include "store/recovery.h"
#include "store/store_directory.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

struct stat status_of(const Directory& directory, const std::string& name) {
  struct stat status {};
  ::fstatat(directory.descriptor(), name.c_str(), &status, AT_SYMLINK_NOFOLLOW);
  return status;
}

std::uint64_t bytes_of(const Directory& directory, const std::string& name) {
  const struct stat status = status_of(directory, name);
  return S_ISREG(status.st_mode) ? 512 * static_cast<std::uint64_t>(status.st_blocks) : 0;
}

/// Repair makes this file and those of a store in its directory.
constexpr char kRepairFile[] = "sealed";
constexpr char kOutputFile[] = "output";  ///< of UnpublishedFile
constexpr char kPlanFile[] = "plan";      ///< of plan_parts()
constexpr std::string_view kReplaced =
    "replaced";  ///< the kind of name of a store that is replaced

bool is_made_file_name(std::string_view name) {
  return is_store_file_name(name) || name == kOutputFile || name == kPlanFile ||
         name == kMadeMarkName || name == kRepairFile;
}

/// Whether the directory proves that plait made it: by its mark, or by the manifest of a store,
/// which is the first file of a store. An empty one has nothing to prove, and nothing to lose.
bool is_made(const Directory& directory) {
  if (directory.names().empty() || has_made_mark(directory)) return true;
  try {
    return is_store(directory) || is_uncommitted(directory);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kCorruption && error.code() != ErrorCode::kNotFound) throw;
    return false;
  }
}

/// A repair works in a directory inside the store.
bool is_of_repair(std::string_view name) {
  const std::optional<UnfinishedNameParts> parts = read_unfinished_name(name);
  return parts && parts->stem == kRepairStem && parts->kind == "repair";
}

/// Calls visit(directory, name) for every file that plait may have made. Returns the names of all
/// other entries but the directories of repairs. REQUIRES: is_made().
template <class Visit>
std::vector<std::string> for_each_file(const Directory& directory, Visit visit) {
  std::vector<std::string> foreign;
  for (const std::string& name : directory.names()) {
    if (is_made_file_name(name))
      visit(directory, name);
    else if (!is_of_repair(name))
      foreign.push_back(name);
  }
  return foreign;
}

/// Nothing if plait did not make the directory.
std::optional<LeftOver> examine(const Directory& directory, const std::string& name,
                                const UnfinishedNameParts& parts) {
  const Directory inner(directory, name);
  if (inner.contains(kKeptMarkName)) return std::nullopt;
  LeftOver found;
  found.name = name;
  found.in_use = may_be_in_use(inner, parts);
  if (!found.in_use && !is_made(inner)) return std::nullopt;
  found.foreign = for_each_file(inner, [&](const Directory& in, const std::string& file) {
    found.bytes += bytes_of(in, file);
  });
  return found;
}

/// Returns false if a file cannot be removed.
bool remove_all_made(const Directory& directory) {
  const auto is_proof = [](std::string_view name) {
    return name == kManifestName || name == kMadeMarkName;
  };
  // The proofs go last: what is left if this process is killed here, or if a file cannot be
  // removed, can be removed later.
  bool all = true;
  for (const bool proofs : {false, true}) {
    for_each_file(directory, [&](const Directory& in, const std::string& file) {
      if (is_proof(file) != proofs) return;
      try {
        in.remove(file);
      } catch (const Error&) {
        all = false;
      }
    });
    if (!all) break;
  }
  return all;
}

bool directory_is_there(const Directory& directory, const std::string& name) {
  const std::vector<std::string> names = directory.names();
  return std::ranges::find(names, name) != names.end();
}

}  // namespace

std::vector<LeftOver> find_left_overs(const Directory& directory, std::string_view of) {
  std::vector<LeftOver> found;
  for (const std::string& name : directory.names()) {
    const std::optional<UnfinishedNameParts> parts = read_unfinished_name(name);
    if (!parts || (!of.empty() && parts->stem != of)) continue;
    // The only store of its name, if the run was killed between two renames.
    if (parts->kind == kReplaced && !directory.contains(std::string(parts->stem))) continue;
    if (!S_ISDIR(status_of(directory, name).st_mode)) continue;
    try {
      if (std::optional<LeftOver> one = examine(directory, name, *parts))
        found.push_back(*std::move(one));
    } catch (const Error& error) {  // another process may have removed it
      if (error.code() != ErrorCode::kNotFound) throw;
    }
  }
  return found;
}

bool remove_left_over(const Directory& directory, const LeftOver& left_over) {
  const std::optional<UnfinishedNameParts> parts = read_unfinished_name(left_over.name);
  try {
    const Directory inner(directory, left_over.name);
    if (!parts || inner.contains(kKeptMarkName) || may_be_in_use(inner, *parts) || !is_made(inner))
      return false;
    remove_left_overs_of_repairs(inner, {});
    return remove_all_made(inner) && directory.remove_directory(left_over.name);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kNotFound) throw;
    return true;  // another process has removed it
  }
}

namespace {

/// A run that was killed between two renames has left the store under an unfinished name.
void put_back(const OutputName& output, const std::string& stem, const Warn& warn) {
  if (output.directory.contains(output.name)) return;
  for (const std::string& name : output.directory.names()) {
    const std::optional<UnfinishedNameParts> parts = read_unfinished_name(name);
    if (!parts || parts->kind != kReplaced || parts->stem != stem) continue;
    const Directory inner(output.directory, name);
    if (may_be_in_use(inner, *parts) || !is_store(inner)) continue;
    if (output.directory.rename(name, output.directory, output.name, Renaming::kRefuse) && warn)
      warn(fmt::format("{}: put back from {}: a run was killed while it replaced the store",
                       output.path.native(), name));
    return;
  }
}

void remove_and_tell(const Directory& directory, const LeftOver& left_over, const Warn& warn) {
  if (left_over.in_use) return;
  const std::string where = directory.path_of(left_over.name).lexically_normal().native();
  std::string said;
  if (remove_left_over(directory, left_over))
    said = fmt::format("removed {} of a killed run ({})", where, format_bytes(left_over.bytes));
  else if (!left_over.foreign.empty())
    said = fmt::format("{} from a killed run stays, because it contains {}", where,
                       fmt::join(left_over.foreign, ", "));
  else if (directory_is_there(directory, left_over.name))
    said = fmt::format("{} from a killed run stays, because some of its files cannot be removed",
                       where);
  if (warn && !said.empty()) warn(said);
}

}  // namespace

void remove_made_files(const Directory& directory) {
  static_cast<void>(remove_all_made(directory));
}

void remove_left_overs_of_repairs(const Directory& store, const Warn& warn) try {
  for (const LeftOver& left_over : find_left_overs(store, kRepairStem))
    if (is_of_repair(left_over.name)) remove_and_tell(store, left_over, warn);
} catch (const Error& error) {
  if (warn) warn(error.what());
}

void remove_left_overs_of(const std::filesystem::path& path, const Warn& warn) {
  const OutputName output(path);
  const std::string stem = UnfinishedName(output.path, "partial").stem_of(output.name);
  put_back(output, stem, warn);
  for (const LeftOver& left_over : find_left_overs(output.directory, stem))
    remove_and_tell(output.directory, left_over, warn);
}

PLAIT_END_NAMESPACE
