#include "plait/left_overs.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>

#include <algorithm>
#include <optional>

#include "plait/byte_text.h"
#include "plait/error.h"
#include "plait/file.h"
#include "plait/partial_output.h"
#include "plait/store_directory.h"

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

/// Repair makes two files and a store in its directory.
constexpr const char* kRepairFiles[] = {"image", "sealed"};
constexpr char kRepairStore[] = "levels";

/// Calls visit(directory, name) for every file that plait may have made. Returns the names of all
/// other entries.
template <class Visit>
std::vector<std::string> for_each_file(const Directory& directory, Visit visit) {
  std::vector<std::string> foreign;
  for (const std::string& name : directory.names()) {
    if (is_store_file_name(name) ||
        std::ranges::find(kRepairFiles, name) != std::end(kRepairFiles)) {
      visit(directory, name);
    } else if (name == kRepairStore && S_ISDIR(status_of(directory, name).st_mode)) {
      const Directory levels(directory, name);
      for (const std::string& inner : levels.names())
        if (is_store_file_name(inner))
          visit(levels, inner);
        else
          foreign.push_back(fmt::format("{}/{}", name, inner));
    } else {
      foreign.push_back(name);
    }
  }
  return foreign;
}

LeftOver examine(const Directory& directory, const std::string& name) {
  LeftOver found;
  found.name = name;
  found.is_directory = S_ISDIR(status_of(directory, name).st_mode);
  if (!found.is_directory) {
    found.bytes = bytes_of(directory, name);
    found.in_use = !File(directory, name, OpenMode::kRead).lock(true);
    return found;
  }
  const Directory inner(directory, name);
  found.in_use = !inner.lock(true);
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
    const struct stat status = status_of(directory, name);
    if (!S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode)) continue;
    try {
      found.push_back(examine(directory, name));
    } catch (const Error& error) {  // another process may have removed it
      if (error.code() != ErrorCode::kNotFound) throw;
    }
  }
  return found;
}

bool remove_left_over(const Directory& directory, const LeftOver& left_over) {
  try {
    if (!left_over.is_directory) {
      File file(directory, left_over.name, OpenMode::kRead);
      if (!file.lock(true)) return false;
      directory.remove(left_over.name);
      return true;
    }
    const Directory inner(directory, left_over.name);
    if (!inner.lock(true)) return false;
    remove_made_files(inner);
    return directory.remove_directory(left_over.name);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kNotFound) throw;
    return true;  // another process has removed it
  }
}

void remove_made_files(const Directory& directory) {
  for_each_file(directory,
                [](const Directory& in, const std::string& file) { in.remove_if_possible(file); });
  directory.remove_directory(kRepairStore);
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
