#include "plait/error.h"
#include "uring/uring_backend.h"

namespace plait {

std::unique_ptr<Backend> open_uring_backend(const LevelSpec& level) {
  validate_uring(level.options);
  return nullptr;
}

void validate_uring(const BackendOptions&) {
  throw Error(ErrorCode::kNotSupported,
              "open backend \"uring\": expected a build with liburing, found one without");
}

}  // namespace plait
