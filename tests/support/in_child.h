// tests/support/in_child.h: work in a child process, which it may change as it likes.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <functional>

namespace plait::test {

/// Whether `work` returns true in a child process.
inline bool in_child(const std::function<bool()>& work) {
  const pid_t child = ::fork();
  if (child == 0) {
    bool good = false;
    try {
      good = work();
    } catch (...) {  // no exception may leave the child
    }
    ::_exit(good ? 0 : 1);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace plait::test
