#include "io/disk_bytes.h"

#include <unistd.h>

#include <cerrno>

PLAIT_BEGIN_PRIVATE_NAMESPACE

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

PLAIT_END_NAMESPACE
