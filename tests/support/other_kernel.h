// tests/support/other_kernel.h: system calls that answer as those of another kernel, of a container
// or of another file system do.
#pragma once

#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <thread>
#include <vector>

namespace plait::test {

/// A system call fails with `error`: each one, or those one of whose arguments has the bits `bits`.
struct Answer {
  long call = 0;
  int error = 0;
  int argument = -1;
  std::uint32_t bits = 0;
};

namespace detail {

inline bool install(const std::vector<Answer>& answers) {
  std::vector<sock_filter> program;
  const auto load = [&](std::size_t offset) {
    program.push_back(BPF_STMT(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(offset)));
  };
  for (const Answer& each : answers) {
    // The first half of an argument has its lower bits: these machines are little-endian.
    const auto rest = static_cast<std::uint8_t>(each.argument < 0 ? 1 : 3);
    load(offsetof(seccomp_data, nr));
    program.push_back(
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(each.call), 0, rest));
    if (each.argument >= 0) {
      load(offsetof(seccomp_data, args) + 8 * static_cast<std::size_t>(each.argument));
      program.push_back(BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, each.bits, 0, 1));
    }
    program.push_back(
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | static_cast<std::uint32_t>(each.error)));
  }
  program.push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW));
  const sock_fprog all{static_cast<unsigned short>(program.size()), program.data()};
  return ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
         ::syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, 0, &all) == 0;
}

}  // namespace detail

/// Calls `work` in a thread of its own. The system calls of this thread, and of the processes that
/// it starts, answer so. Returns false if the system allows no such filter.
inline bool on_other_kernel(const std::vector<Answer>& answers, const std::function<void()>& work) {
  bool is_there = false;
  std::thread([&] {
    is_there = detail::install(answers);
    if (is_there) work();
  }).join();
  return is_there;
}

/// Calls `work` in a thread of its own whose mounts, and those of the processes that it starts,
/// nobody else sees, after `mount`. Returns false if the system does not allow that.
inline bool with_own_mounts(const std::function<bool()>& mount, const std::function<void()>& work) {
  bool is_there = false;
  std::thread([&] {
    is_there = ::unshare(CLONE_NEWNS) == 0 &&
               ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 && mount();
    if (is_there) work();
  }).join();
  return is_there;
}

}  // namespace plait::test
