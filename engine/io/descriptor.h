// io/descriptor.h: descriptors of a store never have the numbers of the standard streams.
//
// A host may have closed descriptors 0, 1 or 2. The kernel gives the lowest free number, so a file
// of a store could get one of them, and what the host prints would go into the store.
#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The lowest number that a descriptor of the library may have.
inline constexpr int kLowestDescriptor = 3;

/// Returns `opened`, or, if its number is that of a standard stream, a duplicate with a higher
/// number, and closes `opened`. -1 with errno, as the call that opened it.
inline int above_standard_streams(int opened) noexcept {
  if (opened < 0 || opened >= kLowestDescriptor) return opened;
  const int moved = ::fcntl(opened, F_DUPFD_CLOEXEC, kLowestDescriptor);
  const int error = errno;
  ::close(opened);
  errno = error;
  return moved;
}

/// Takes the free numbers of the standard streams, so that a library call that opens descriptors of
/// its own gets higher ones. The destructor frees them. The descriptors can be neither read nor
/// written (O_PATH).
class StandardStreamsTaken {
 public:
  StandardStreamsTaken() noexcept {
    for (int& number : taken_) {
      number = ::open("/", O_PATH | O_DIRECTORY | O_CLOEXEC);
      if (number < kLowestDescriptor) continue;
      ::close(number);
      number = -1;
      return;
    }
  }
  ~StandardStreamsTaken() {
    for (const int number : taken_)
      if (number >= 0) ::close(number);
  }
  StandardStreamsTaken(const StandardStreamsTaken&) = delete;
  StandardStreamsTaken& operator=(const StandardStreamsTaken&) = delete;

 private:
  std::array<int, kLowestDescriptor> taken_{-1, -1, -1};
};

PLAIT_END_NAMESPACE
