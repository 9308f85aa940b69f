#include "instrument/disk.h"

#include <fmt/format.h>
#include <mntent.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <sys/sysmacros.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <memory>
#include <system_error>

#include "base/text.h"
#include "instrument/process.h"
#include "plait/error.h"

namespace plait::instrument {
namespace {

namespace fs = std::filesystem;

std::string line_of(const fs::path& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line.substr(0, line.find_last_not_of(' ') + 1);
}

bool is_inside(const std::string& path, const std::string& directory) {
  return directory == "/" || path == directory || path.starts_with(directory + "/");
}

/// Fills in what the kernel says of the mount that has the directory: the longest mount point, and
/// the last of equal ones, which hides the others.
void find_mount(const std::string& path, DiskFacts& facts) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> mounts(
      ::setmntent("/proc/self/mounts", "r"), ::endmntent);
  if (!mounts) return;
  mntent entry{};
  std::array<char, 4096> text;
  while (::getmntent_r(mounts.get(), &entry, text.data(), static_cast<int>(text.size())) != nullptr)
    if (is_inside(path, entry.mnt_dir) && std::strlen(entry.mnt_dir) >= facts.mount_point.size()) {
      facts.mount_point = entry.mnt_dir;
      facts.mount_options = entry.mnt_opts;
      facts.file_system = entry.mnt_type;
      facts.source = entry.mnt_fsname;
    }
}

/// /sys/dev/block/M:N of the device. btrfs and others give a directory the number of no device;
/// then the source of the mount names it.
fs::path device_directory(const DiskFacts& facts) {
  struct stat status {};
  std::error_code failed;
  const auto of = [](dev_t number) {
    return fs::path(fmt::format("/sys/dev/block/{}:{}", major(number), minor(number)));
  };
  if (::stat(facts.directory.c_str(), &status) == 0 && fs::exists(of(status.st_dev), failed))
    return of(status.st_dev);
  if (::stat(facts.source.c_str(), &status) == 0 && S_ISBLK(status.st_mode) &&
      fs::exists(of(status.st_rdev), failed))
    return of(status.st_rdev);
  return {};
}

/// "[none] mq-deadline" names the scheduler in brackets.
std::string chosen(const std::string& list) {
  const std::size_t first = list.find('['), last = list.find(']');
  return first == std::string::npos || last == std::string::npos
             ? list
             : list.substr(first + 1, last - first - 1);
}

}  // namespace

std::string DiskFacts::name() const {
  return device.empty() ? file_system : fmt::format("{} on {}", file_system, device);
}

DiskFacts disk_facts(const fs::path& directory) {
  std::error_code failed;
  const fs::path path = fs::canonical(directory, failed);
  if (failed) throw system_error("find", directory.native(), failed.value());
  DiskFacts facts;
  facts.directory = path;
  find_mount(path.native(), facts);
  struct statvfs space {};
  if (::statvfs(path.c_str(), &space) != 0)
    throw system_error("find the space of", path.native(), errno);
  facts.bytes = static_cast<std::uint64_t>(space.f_blocks) * space.f_frsize;
  facts.free_bytes = static_cast<std::uint64_t>(space.f_bavail) * space.f_frsize;
  facts.in_memory = facts.file_system == "tmpfs" || facts.file_system == "ramfs";
  const fs::path device = device_directory(facts);
  if (device.empty()) return facts;
  const fs::path real = fs::canonical(device, failed);
  facts.device = real.filename();
  // A partition has no queue of its own.
  const fs::path disk = fs::exists(real / "queue", failed) ? real : real.parent_path();
  facts.scheduler = chosen(line_of(disk / "queue/scheduler"));
  facts.model = line_of(disk / "device/model");
  facts.rotational = line_of(disk / "queue/rotational") == "1";
  facts.read_ahead_bytes = number_in(disk / "queue/read_ahead_kb").value_or(0) * 1024;
  return facts;
}

nlohmann::ordered_json to_json(const DiskFacts& facts) {
  return {{"directory", facts.directory.native()},
          {"name", facts.name()},
          {"file_system", facts.file_system},
          {"mount_point", facts.mount_point},
          {"mount_options", facts.mount_options},
          {"source", facts.source},
          {"device", facts.device},
          {"model", facts.model},
          {"scheduler", facts.scheduler},
          {"read_ahead_bytes", facts.read_ahead_bytes},
          {"rotational", facts.rotational},
          {"in_memory", facts.in_memory},
          {"bytes", facts.bytes},
          {"free_bytes", facts.free_bytes}};
}

Traffic device_traffic(const DiskFacts& facts) {
  // Fields of Documentation/block/stat.rst; a sector is 512 bytes on every device.
  if (facts.device.empty()) return {};
  std::ifstream file(fs::path("/sys/class/block") / facts.device / "stat");
  std::array<std::uint64_t, 7> fields{};
  for (std::uint64_t& field : fields)
    if (!(file >> field)) return {};
  return {true, fields[2] * 512, fields[6] * 512};
}

Traffic operator-(const Traffic& after, const Traffic& before) {
  if (!after.known || !before.known) return {};
  return {true, after.bytes_read - before.bytes_read, after.bytes_written - before.bytes_written};
}

Traffic process_traffic() {
  const auto read = number_in("/proc/self/io", "read_bytes:");
  const auto written = number_in("/proc/self/io", "write_bytes:");
  return {read.has_value(), read.value_or(0), written.value_or(0)};
}

std::uint64_t usable_bytes(const DiskFacts& facts) {
  const std::uint64_t kept = facts.bytes / 10;
  return facts.free_bytes > kept ? facts.free_bytes - kept : 0;
}

void require_space(const fs::path& directory, std::uint64_t bytes) {
  if (const std::uint64_t usable = usable_bytes(disk_facts(directory)); usable < bytes)
    throw Error(ErrorCode::kNoSpace,
                fmt::format("measure under {}: needs {}, and {} may be used so that a tenth of the "
                            "disk stays free",
                            directory.native(), format_bytes(bytes), format_bytes(usable)));
}

}  // namespace plait::instrument
