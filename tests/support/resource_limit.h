// tests/support/resource_limit.h: sets a limit for this process and its children, as long as the
// object lives.
#pragma once

#include <sys/resource.h>

#include <cerrno>
#include <cstdint>
#include <system_error>

namespace plait::test {

/// Sanitizers need terabytes of address space.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kAddressSpaceCanBeLimited = false;
#else
constexpr bool kAddressSpaceCanBeLimited = true;
#endif

/// Sets the soft limit. The destructor restores the old one.
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
