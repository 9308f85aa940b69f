// tests/support/resource_limit.h: a limit of this process, and of those that it starts, for a
// while.
#pragma once

#include <sys/resource.h>

#include <cerrno>
#include <cstdint>
#include <system_error>

namespace plait::test {

/// Sanitizers take terabytes of addresses for themselves.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kAddressSpaceCanBeLimited = false;
#else
constexpr bool kAddressSpaceCanBeLimited = true;
#endif

/// Puts the soft limit back when it ends.
class ResourceLimit {
 public:
  ResourceLimit(__rlimit_resource resource, std::uint64_t limit) : resource_(resource) {
    ::getrlimit(resource_, &before_);
    set({limit, before_.rlim_max});
  }
  ~ResourceLimit() { ::setrlimit(resource_, &before_); }
  ResourceLimit(const ResourceLimit&) = delete;
  ResourceLimit& operator=(const ResourceLimit&) = delete;

 private:
  void set(const rlimit& limit) const {
    if (::setrlimit(resource_, &limit) != 0)
      throw std::system_error(errno, std::generic_category(), "setrlimit");
  }

  __rlimit_resource resource_;
  rlimit before_{};
};

}  // namespace plait::test
