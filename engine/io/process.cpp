#include "io/process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <pthread.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <mutex>
#include <vector>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The descriptors that have locks. It is never destroyed, because files may be closed while
/// the process ends.
struct LockedFiles {
  std::mutex mutex;
  std::vector<int> descriptors;
};

LockedFiles& locked_files() {
  static auto& files = *new LockedFiles;
  return files;
}

}  // namespace

void OwnProcess::watch_forks() noexcept {
  [[maybe_unused]] static const int watching =
      ::pthread_atfork([] { locked_files().mutex.lock(); }, [] { locked_files().mutex.unlock(); },
                       [] {
                         current().fetch_add(1, std::memory_order_relaxed);
                         // The lock belongs to the open file, and ends with its last descriptor.
                         const int nothing = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
                         for (const int descriptor : locked_files().descriptors)
                           if (nothing < 0)
                             ::close(descriptor);
                           else
                             ::dup3(nothing, descriptor, O_CLOEXEC);
                         if (nothing >= 0) ::close(nothing);
                         locked_files().descriptors.clear();
                         locked_files().mutex.unlock();
                       });
}

OwnProcess::OwnProcess() noexcept {
  watch_forks();
  number_ = current().load(std::memory_order_relaxed);
}

void OwnProcess::refuse(std::string_view what) {
  throw Error(
      ErrorCode::kBadState,
      fmt::format("use {} in process {}: it belongs to the process that this one was forked "
                  "from; open the store again in this process",
                  what, ::getpid()));
}

void keep_lock_from_children(int descriptor) {
  static const OwnProcess watching;
  LockedFiles& files = locked_files();
  const std::scoped_lock lock(files.mutex);
  if (std::ranges::find(files.descriptors, descriptor) == files.descriptors.end())
    files.descriptors.push_back(descriptor);
}

void release_lock(int descriptor) noexcept {
  LockedFiles& files = locked_files();
  const std::scoped_lock lock(files.mutex);
  if (std::erase(files.descriptors, descriptor) > 0) ::flock(descriptor, LOCK_UN);
}

PLAIT_END_NAMESPACE
