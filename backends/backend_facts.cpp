// The facts that choose_backend() decides by, as this machine gives them.
#include <fcntl.h>
#include <fmt/format.h>
#include <linux/magic.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <system_error>

#include "built_in_backends.h"
#include "choose_backend.h"
#include "io/machine.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Why this machine, or the registry, has no such backend; empty if it has.
std::string refusal(const BackendRegistry& backends, const char* name) {
  try {
    const RegisteredBackend& backend = backends.find(name);
    if (backend.check_machine) backend.check_machine();
    if (backend.name == "uring") check_uring();  // pread would stand in for it
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

StoreMedium medium_of(const std::filesystem::path& directory) {
  struct statfs status {};
  if (::statfs(directory.c_str(), &status) != 0) return StoreMedium::kUnknown;
  const auto magic = static_cast<std::uint32_t>(status.f_type);
  if (magic == TMPFS_MAGIC || magic == RAMFS_MAGIC) return StoreMedium::kMemory;
  // Those that <linux/magic.h> does not have in every version, by their numbers: CIFS, SMB 2 and 3,
  // Ceph, FUSE, Lustre.
  constexpr std::array<std::uint32_t, 9> kNetworks = {NFS_SUPER_MAGIC, SMB_SUPER_MAGIC, V9FS_MAGIC,
                                                      AFS_SUPER_MAGIC, 0xff534d42,      0xfe534d42,
                                                      0x00c36400,      0x65735546,      0x0bd00bd0};
  if (std::ranges::find(kNetworks, magic) != kNetworks.end()) return StoreMedium::kNetwork;
  return StoreMedium::kDisk;
}

/// Tries it, with a file that has no name.
std::string direct_refusal(const std::filesystem::path& directory) {
  const int file =
      ::open(directory.c_str(), O_TMPFILE | O_RDWR | O_DIRECT | O_CLOEXEC, S_IRUSR | S_IWUSR);
  if (file < 0)
    return fmt::format("its file system has no O_DIRECT ({})",
                       std::generic_category().message(errno));
  ::close(file);
  return {};
}

}  // namespace

BackendFacts backend_facts(const BackendRegistry& backends, const NewStore& store) {
  BackendFacts facts{.level_bytes = store.level_bytes,
                     .available_bytes = store.available_bytes.value_or(available_memory_bytes()),
                     .in_memory = store.path.empty(),
                     .has_pipelines = store.has_pipelines};
  if (facts.in_memory || facts.has_pipelines) return facts;
  // A path that ends with a slash has an empty name.
  const std::filesystem::path path =
      store.path.has_filename() ? store.path : store.path.parent_path();
  const std::filesystem::path parent = path.parent_path();
  const std::filesystem::path directory = parent.empty() ? "." : parent;
  facts.medium = medium_of(directory);
  facts.no_mmap = refusal(backends, "mmap");
  facts.no_uring = refusal(backends, "uring");
  facts.no_direct = direct_refusal(directory);
  return facts;
}

PLAIT_END_NAMESPACE
