// bench/micro/work_directory.h: a directory for the files of a measurement, which is removed
// however the measurement ends.
#pragma once

#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <string>

#include "instrument/scratch_directory.h"
#include "plait/error.h"

namespace plait::bench {

/// Makes a new directory in `directory` and stores its path in `directory`. Then runs `work` in a
/// child process and returns the child's exit status. Removes the new directory when the child has
/// ended. On SIGINT, SIGTERM or SIGHUP, the function kills the child and the processes that the
/// child started, and returns 128 plus the number of the signal. REQUIRES: this process has one
/// thread.
/// Errors: kIo, kNotFound.
template <class Work>
int in_work_directory(std::string& directory, Work work) {
  sigset_t awaited, before;
  sigemptyset(&awaited);
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGCHLD}) sigaddset(&awaited, number);
  // Signals are blocked before the directory exists, so that no signal can leave it behind.
  ::sigprocmask(SIG_BLOCK, &awaited, &before);
  const instrument::ScratchDirectory scratch(directory);
  directory = scratch.path().native();
  std::fflush(nullptr);
  const pid_t child = ::fork();
  if (child == 0) {
    ::setpgid(0, 0);
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    ::sigprocmask(SIG_SETMASK, &before, nullptr);
    const int status = work();
    std::fflush(nullptr);
    ::_exit(status);
  }
  int status = 1;
  const int failure = child < 0 ? errno : 0;
  if (child > 0) {
    ::setpgid(child, child);  // parent and child both call this, because either may run first
    int received = 0, ended = 0;
    ::sigwait(&awaited, &received);
    if (received != SIGCHLD) ::kill(-child, SIGKILL);
    ::waitpid(child, &ended, 0);
    status = received != SIGCHLD ? 128 + received
             : WIFEXITED(ended)  ? WEXITSTATUS(ended)
                                 : 128 + WTERMSIG(ended);
  }
  ::sigprocmask(SIG_SETMASK, &before, nullptr);
  if (failure != 0) throw system_error("make", "process", failure);
  return status;
}

}  // namespace plait::bench
