#include "parts/part_directory.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <exception>
#include <fstream>
#include <random>

#include "format/file_names.h"
#include "parts/done_file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

std::string random_hex() {
  std::random_device device;
  return fmt::format("{:08x}", device());
}

/// The name of the host and the number of the kernel's start. Processes with the same two see each
/// other's locks (flock), also from different containers. The name alone does not say that: on many
/// file systems two machines of one name, as containers often have, do not see each other's locks.
std::string machine_name() {
  std::array<char, 256> name{};
  std::string host = "host";
  if (::gethostname(name.data(), name.size() - 1) == 0) host = name.data();
  for (char& c : host)
    if (c == '-' || !is_in_directory_names(c)) c = '_';
  std::string start;
  std::ifstream("/proc/sys/kernel/random/boot_id") >> start;
  start.resize(std::min<std::size_t>(start.size(), 8));
  return fmt::format("{}-{}", host, start.empty() ? random_hex() : start);
}

}  // namespace

std::string own_prefix(std::uint32_t part) {
  static const std::string machine = machine_name();
  return fmt::format("{}{}-", part_prefix(part), machine);
}

PartDirectory::PartDirectory(const Directory& plan, std::uint32_t part) : plan_(plan) {
  // Another process may remove the directory as a left-over before it is locked.
  do {
    name_ = own_prefix(part) + random_hex() + random_hex();
    made_ = Directory::make(plan.path_of(name_));
  } while (!made_.lock(true) || !plan.contains(name_, made_.descriptor()));
}

PartDirectory::~PartDirectory() {
  if (!is_kept_) remove(plan_, name_);
}

void PartDirectory::remove(const Directory& plan, const std::string& name) noexcept {
  try {
    const Directory made(plan, name);
    for (const std::string& file : made.names())
      if (is_version_file_name(file) || file == kRecordsName || file.starts_with("done."))
        made.remove_if_possible(file);
    plan.remove_directory(name);
  } catch (const std::exception&) {  // what stays does no harm
  }
}

PLAIT_END_NAMESPACE
