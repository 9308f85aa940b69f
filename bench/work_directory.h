// bench/work_directory.h: a directory for the files of a measurement, gone whatever ends it.
#pragma once

#include <signal.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <string>
#include <system_error>

#include "plait/error.h"

namespace plait::bench {

/// Makes a directory of its own in `directory`, puts its name into `directory`, and runs `work` in
/// a child process, whose exit status it returns. Removes the directory when the child has ended,
/// also where a signal ends this process: SIGINT, SIGTERM and SIGHUP kill the child and those that
/// it started; the status is then 128 and the signal. REQUIRES: this process has one thread.
/// Errors: kIo, kNotFound.
template <class Work>
int in_work_directory(std::string& directory, Work work) {
  sigset_t awaited, before;
  sigemptyset(&awaited);
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGCHLD}) sigaddset(&awaited, number);
  // Before there is anything that would have to be removed.
  ::sigprocmask(SIG_BLOCK, &awaited, &before);
  std::string name = (std::filesystem::path(directory) / "plait-bench-XXXXXX").native();
  if (::mkdtemp(name.data()) == nullptr) {
    const int failure = errno;
    ::sigprocmask(SIG_SETMASK, &before, nullptr);
    throw system_error("create", name, failure);
  }
  directory = name;
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
    ::setpgid(child, child);  // whichever of the two comes first
    int received = 0, ended = 0;
    ::sigwait(&awaited, &received);
    if (received != SIGCHLD) ::kill(-child, SIGKILL);
    ::waitpid(child, &ended, 0);
    status = received != SIGCHLD ? 128 + received
             : WIFEXITED(ended)  ? WEXITSTATUS(ended)
                                 : 128 + WTERMSIG(ended);
  }
  std::error_code ignored;
  std::filesystem::remove_all(name, ignored);
  ::sigprocmask(SIG_SETMASK, &before, nullptr);
  if (failure != 0) throw system_error("make", "process", failure);
  return status;
}

}  // namespace plait::bench
