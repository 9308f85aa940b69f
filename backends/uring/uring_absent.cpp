#include "plait/error.h"
#include "uring/uring_backend.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

std::unique_ptr<Volume> open_uring_volume(const VolumeSpec& volume) {
  validate_uring(volume.options);
  return nullptr;
}

void validate_uring(std::string_view) {
  throw Error(ErrorCode::kNotSupported,
              "open backend \"uring\": expected a build with liburing, found one without");
}

PLAIT_END_NAMESPACE
