#include "io/machine.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <fstream>
#include <limits>
#include <random>
#include <string>
#include <string_view>
#include <system_error>

#include "io/control_groups.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kAny = std::numeric_limits<std::uint64_t>::max();

/// The number in a file; kAny if the file contains no number ("max") or does not exist.
std::uint64_t number_in(const fs::path& path) {
  std::ifstream file(path);
  std::uint64_t number = 0;
  return file >> number ? number : kAny;
}

/// The number after the word `key`; `otherwise` if the file has no such number.
std::uint64_t number_after(const fs::path& path, std::string_view key, std::uint64_t otherwise) {
  std::ifstream file(path);
  for (std::string word; file >> word;)
    if (std::uint64_t number = 0; word == key && file >> number) return number;
  return otherwise;
}

std::uint64_t difference(std::uint64_t limit, std::uint64_t used) {
  return limit == kAny ? kAny : limit - std::min(limit, used);
}

/// The free bytes of the process's groups: the minimum of them. Page cache counts as free, because
/// the kernel drops it when a process needs memory.
std::uint64_t left_in_memory_groups() {
  std::uint64_t left = kAny;
  for (const auto& [directory, is_version_2] : control_groups("memory")) {
    const std::uint64_t bytes =
        number_in(directory / (is_version_2 ? "memory.max" : "memory.limit_in_bytes"));
    if (bytes == kAny) continue;
    std::uint64_t of_files = 0;
    for (const std::string kind : {"inactive_file", "active_file"})
      of_files += number_after(directory / "memory.stat", is_version_2 ? kind : "total_" + kind, 0);
    const std::uint64_t used =
        number_in(directory / (is_version_2 ? "memory.current" : "memory.usage_in_bytes"));
    left = std::min(left, difference(bytes, used == kAny ? 0 : used - std::min(used, of_files)));
  }
  return left;
}

std::uint64_t left_of_address_space() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return kAny;
  const std::uint64_t pages = number_in("/proc/self/statm");
  const auto page_bytes = static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  return difference(limit.rlim_cur, pages == kAny ? 0 : pages * page_bytes);
}

}  // namespace

std::filesystem::path absolute_path(const std::filesystem::path& path) {
  std::error_code failure;
  std::filesystem::path result = std::filesystem::absolute(path, failure);
  if (failure)
    throw Error(ErrorCode::kNotFound, fmt::format("open {}: the path is relative, and the current "
                                                  "directory is not there any more",
                                                  path.native()))
        .about(path);
  return result;
}

std::uint64_t available_memory_bytes() {
  const std::uint64_t kibibytes = number_after("/proc/meminfo", "MemAvailable:", kAny);
  return std::min({kibibytes == kAny ? kAny : kibibytes * 1024, left_in_memory_groups(),
                   left_of_address_space()});
}

std::uint64_t free_disk_bytes(const std::filesystem::path& path) {
  fs::path at = absolute_path(path);
  struct statvfs status {};
  while (::statvfs(at.c_str(), &status) != 0) {
    if ((errno != ENOENT && errno != ENOTDIR) || !at.has_relative_path()) return kAny;
    at = at.parent_path();
  }
  if (status.f_blocks == 0) return kAny;  // the file system does not know, as many of FUSE
  return static_cast<std::uint64_t>(status.f_bavail) * status.f_frsize;
}

std::uint64_t largest_file_bytes() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_FSIZE, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return kAny;
  return limit.rlim_cur;
}

std::uint64_t bytes_on_disk(const File& file, std::uint64_t enough) {
  std::uint64_t counted = 0;
  for (off_t hole = 0; counted < enough;) {
    const off_t data = ::lseek(file.descriptor(), hole, SEEK_DATA);
    if (data < 0) return errno == ENXIO ? counted : file.size();
    hole = ::lseek(file.descriptor(), data, SEEK_HOLE);
    if (hole < 0) return file.size();
    counted += static_cast<std::uint64_t>(hole - data);
  }
  return counted;
}

namespace {

OwnMachine find_own_machine() {
  constexpr std::size_t kMostOfHost = 32, kStart = 8;
  OwnMachine machine;
  std::array<char, 256> name{};
  machine.host = ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "host";
  machine.host.resize(std::min(machine.host.size(), kMostOfHost));
  for (char& c : machine.host)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '.') c = '_';
  if (machine.host.empty()) machine.host = "host";
  std::ifstream("/proc/sys/kernel/random/boot_id") >> machine.start;
  machine.start.resize(std::min(machine.start.size(), kStart));
  if (machine.start.empty()) machine.start = random_hex();
  return machine;
}

}  // namespace

const OwnMachine& own_machine() {
  static const OwnMachine machine = find_own_machine();
  return machine;
}

namespace {

/// 0 if it is not known.
std::uint64_t process_namespace() noexcept {
  struct stat status {};
  return ::stat("/proc/self/ns/pid", &status) == 0 ? status.st_ino : 0;
}

}  // namespace

std::string new_maker_name() {
  const OwnMachine& own = own_machine();
  return fmt::format("{}-{}-{:x}.{:x}.{}{}", own.host, own.start, process_namespace(), ::getpid(),
                     random_hex(), random_hex());
}

std::optional<Maker> read_maker(std::string_view name) {
  const std::size_t after_host = name.find('-');
  if (after_host == std::string_view::npos) return std::nullopt;
  const std::size_t after_start = name.find('-', after_host + 1);
  if (after_start == std::string_view::npos || after_start + 1 == name.size()) return std::nullopt;
  Maker maker;
  maker.host = name.substr(0, after_host);
  maker.start = name.substr(after_host + 1, after_start - after_host - 1);
  if (const std::size_t dot = name.rfind('.'); dot != std::string_view::npos && dot > after_start)
    maker.process = name.substr(after_start + 1, dot - after_start - 1);
  return maker;
}

bool has_ended(std::string_view process) noexcept {
  const std::size_t dot = process.find('.');
  if (dot == std::string_view::npos) return false;
  std::uint64_t space = 0;
  pid_t number = 0;
  const char* const end = process.data() + process.size();
  if (std::from_chars(process.data(), process.data() + dot, space, 16).ec != std::errc() ||
      std::from_chars(process.data() + dot + 1, end, number, 16).ec != std::errc())
    return false;
  return space != 0 && space == process_namespace() && number > 0 && ::kill(number, 0) != 0 &&
         errno == ESRCH;
}

std::string random_hex() {
  std::random_device device;
  return fmt::format("{:08x}", device());
}

PLAIT_END_NAMESPACE
