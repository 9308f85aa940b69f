#include "built_in_backends.h"
#include "plait/error.h"
#include "uring/pread_instead.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

std::unique_ptr<Volume> open_uring_volume(const VolumeSpec& volume) {
  try {
    check_uring();
    return nullptr;
  } catch (const Error& error) {
    return std::make_unique<PreadInstead>(volume, error);
  }
}

void check_uring() {
  throw Error(ErrorCode::kNotSupported,
              "open backend \"uring\": expected a build with liburing, found one without");
}

PLAIT_END_NAMESPACE
