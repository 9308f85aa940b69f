#include "parts/files_of_parts.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <iterator>

#include "format/file_names.h"
#include "parts/files_at_once.h"
#include "plait/error.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

void give_files_of_parts(const Directory& plan_directory, const std::vector<DoneFile>& parts,
                         std::uint64_t version, const Directory& store,
                         void (*give)(const Directory& from, const std::string& name,
                                      const Directory& to),
                         const std::function<void(std::size_t)>& tell,
                         std::vector<ExpectedFile>& expected) {
  std::vector<std::vector<ExpectedFile>> of_parts(parts.size());
  const auto give_part = [&](std::size_t at) {
    const DoneFile& done = parts[at];
    const Directory inside(plan_directory, done.directory);
    for (const auto& [name, bytes] : done.files) {
      give(inside, name, store);
      of_parts[at].push_back({name, bytes});
    }
    const std::string tables = tables_file_name(version, done.part);
    give(inside, tables, store);
    of_parts[at].push_back({tables, File(inside, tables, OpenMode::kRead).size()});
  };
  each_file_at_once(parts.size(), "a join", give_part, tell);
  for (std::vector<ExpectedFile>& files : of_parts)
    std::ranges::move(files, std::back_inserter(expected));
}

void check_files(const Directory& directory, const std::vector<ExpectedFile>& expected,
                 const std::string& what) {
  const auto check = [&](std::size_t at) {
    const auto& [name, bytes] = expected[at];
    struct stat status {};
    const bool is_there =
        ::fstatat(directory.descriptor(), name.c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0 &&
        S_ISREG(status.st_mode);
    if (is_there && static_cast<std::uint64_t>(status.st_size) == bytes) return;
    const std::string found = is_there ? fmt::format("{} of them", status.st_size) : "no such file";
    throw Error(ErrorCode::kBusy,
                fmt::format("{}: expected {} bytes in {}, found {}: another process works in {}",
                            what, bytes, name, found, directory.path().native()));
  };
  each_file_at_once(expected.size(), "a join", check, {});
}

PLAIT_END_NAMESPACE
