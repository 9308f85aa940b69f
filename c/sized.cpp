#include "sized.h"

#include <fmt/format.h>

namespace plait::c {

void check_size(const void* given, std::size_t smallest, std::size_t known) {
  // No version of a structure is near this size: the member was not set.
  constexpr std::size_t kMost = 4096;
  std::size_t size = 0;
  std::memcpy(&size, given, sizeof(size));
  if (size < smallest || size > kMost)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("member 'struct_size': expected {} to {}, found {}; make the structure "
                            "by its macro PLAIT_..._INIT",
                            smallest, kMost, size));
  const auto* const bytes = static_cast<const unsigned char*>(given);
  for (std::size_t at = known; at < size; ++at)
    if (bytes[at] != 0)
      throw Error(ErrorCode::kNotSupported,
                  fmt::format("a structure of {} bytes has a member that this library does not "
                              "know: it knows {} bytes (interface version {})",
                              size, known, PLAIT_ABI_VERSION));
}

}  // namespace plait::c
