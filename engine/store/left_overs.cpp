#include "store/left_overs.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>

#include <algorithm>
#include <optional>

#include "base/byte_text.h"
#include "format/file_names.h"
#include "io/made_mark.h"
#include "io/partial_output.h"
#include "plait/error.h"
#include "plait/extend/file.h"
#include "store/recovery.h"
#include "store/store_directory.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The part NAME of "NAME.partial-12" or "NAME.repair-12-3".
std::optional<std::string_view> final_name_of(std::string_view name) {
  const std::size_t digits = name.find_last_not_of("0123456789-");
  if (digits == std::string_view::npos || digits + 2 >= name.size() || name[digits + 1] != '-')
    return std::nullopt;
  const std::string_view before = name.substr(0, digits + 1);
  for (const std::string_view kind : {".partial", ".repair"})
    if (before.ends_with(kind) && before.size() > kind.size())
      return before.substr(0, before.size() - kind.size());
  return std::nullopt;
}

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
constexpr char kOutputFile[] = "output";  ///< of PartialFile
constexpr char kPlanFile[] = "plan";      ///< of plan_parts()

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

/// Calls visit(directory, name) for every file that plait may have made. Returns the names of all
/// other entries. REQUIRES: is_made().
template <class Visit>
std::vector<std::string> for_each_file(const Directory& directory, Visit visit) {
  std::vector<std::string> foreign;
  for (const std::string& name : directory.names()) {
    if (is_made_file_name(name))
      visit(directory, name);
    else
      foreign.push_back(name);
  }
  return foreign;
}

/// Nothing if plait did not make the directory.
std::optional<LeftOver> examine(const Directory& directory, const std::string& name) {
  const Directory inner(directory, name);
  LeftOver found;
  found.name = name;
  found.in_use = !inner.lock(true);
  if (!found.in_use && !is_made(inner)) return std::nullopt;
  found.foreign = for_each_file(inner, [&](const Directory& in, const std::string& file) {
    found.bytes += bytes_of(in, file);
  });
  return found;
}

}  // namespace

std::vector<LeftOver> find_left_overs(const Directory& directory, std::string_view of) {
  std::vector<LeftOver> found;
  for (const std::string& name : directory.names()) {
    const std::optional<std::string_view> final_name = final_name_of(name);
    if (!final_name || (!of.empty() && *final_name != of)) continue;
    if (!S_ISDIR(status_of(directory, name).st_mode)) continue;
    try {
      if (std::optional<LeftOver> one = examine(directory, name)) found.push_back(*std::move(one));
    } catch (const Error& error) {  // another process may have removed it
      if (error.code() != ErrorCode::kNotFound) throw;
    }
  }
  return found;
}

bool remove_left_over(const Directory& directory, const LeftOver& left_over) {
  try {
    const Directory inner(directory, left_over.name);
    if (!inner.lock(true) || !is_made(inner)) return false;
    remove_made_files(inner);
    return directory.remove_directory(left_over.name);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kNotFound) throw;
    return true;  // another process has removed it
  }
}

void remove_made_files(const Directory& directory) {
  const auto is_proof = [](std::string_view name) {
    return name == kManifestName || name == kMadeMarkName;
  };
  // The proofs go last: what is left if this process is killed here can be removed, too.
  for (const bool proofs : {false, true}) {
    for_each_file(directory, [&](const Directory& in, const std::string& file) {
      if (is_proof(file) == proofs) in.remove_if_possible(file);
    });
  }
}

void remove_left_overs_of(const std::filesystem::path& path,
                          const std::function<void(const std::string&)>& warn) {
  const OutputName output(path);
  for (const LeftOver& left_over : find_left_overs(output.directory, output.name)) {
    if (left_over.in_use) continue;
    const std::string where = output.directory.path_of(left_over.name).lexically_normal().native();
    if (remove_left_over(output.directory, left_over))
      warn(fmt::format("removed {} of a killed run ({})", where, format_bytes(left_over.bytes)));
    else if (!left_over.foreign.empty())
      warn(fmt::format("{} from a killed run stays, because it contains {}", where,
                       fmt::join(left_over.foreign, ", ")));
  }
}

PLAIT_END_NAMESPACE
