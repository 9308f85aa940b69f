#include "instrument/process.h"

#include <fmt/format.h>
#include <malloc.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <fstream>

#include "instrument/memory_limit.h"
#include "plait/error.h"

namespace plait::instrument {
namespace {

double seconds_of(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

bool send(int to, const std::string& text) {
  for (std::size_t sent = 0; sent < text.size();) {
    const ssize_t count = ::write(to, text.data() + sent, text.size() - sent);
    if (count < 0 && errno != EINTR) return false;
    if (count > 0) sent += static_cast<std::size_t>(count);
  }
  return true;
}

std::string receive(int from) {
  std::string text;
  char part[4096];
  for (;;) {
    const ssize_t count = ::read(from, part, sizeof part);
    if (count == 0 || (count < 0 && errno != EINTR)) return text;
    if (count > 0) text.append(part, static_cast<std::size_t>(count));
  }
}

/// What the child does: never returns.
[[noreturn]] void work_and_answer(int to, pid_t parent, const std::function<nlohmann::json()>& work,
                                  const MemoryLimit* limit) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(1);  // it died before the line above
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) ::signal(number, SIG_DFL);
  nlohmann::json answer;
  try {
    if (limit != nullptr) limit->enter();
    std::ofstream("/proc/self/clear_refs") << "5";  // VmHWM counts from now on
    answer["result"] = work();
  } catch (const Error& error) {
    answer = {{"error", error.what()}, {"code", static_cast<int>(error.code())}};
  } catch (const std::bad_alloc&) {
    answer = {{"error", "out of memory"}, {"code", static_cast<int>(ErrorCode::kOutOfMemory)}};
  } catch (const std::exception& error) {
    answer = {{"error", error.what()}, {"code", static_cast<int>(ErrorCode::kIo)}};
  }
  answer["peak"] = memory_status("VmHWM");
  std::fflush(nullptr);
  ::_exit(send(to, answer.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)) ? 0 : 1);
}

}  // namespace

ProcessResult run_in_own_process(const std::function<nlohmann::json()>& work,
                                 const MemoryLimit* limit) {
  int ends[2];
  if (::pipe(ends) != 0) throw system_error("make", "a pipe", errno);
  std::fflush(nullptr);
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child < 0) {
    const int failure = errno;
    ::close(ends[0]);
    ::close(ends[1]);
    throw system_error("start", "a process", failure);
  }
  if (child == 0) {
    ::close(ends[0]);
    work_and_answer(ends[1], parent, work, limit);
  }
  ::close(ends[1]);
  const std::string text = receive(ends[0]);
  ::close(ends[0]);
  int status = 0;
  rusage usage{};
  while (::wait4(child, &status, 0, &usage) < 0 && errno == EINTR) {
  }
  ProcessResult got;
  got.figures = {.user_seconds = seconds_of(usage.ru_utime),
                 .system_seconds = seconds_of(usage.ru_stime),
                 .minor_faults = static_cast<std::uint64_t>(usage.ru_minflt),
                 .major_faults = static_cast<std::uint64_t>(usage.ru_majflt)};
  if (WIFSIGNALED(status)) {
    const bool memory = limit != nullptr && limit->limited() && WTERMSIG(status) == SIGKILL;
    throw Error(memory ? ErrorCode::kOutOfMemory : ErrorCode::kIo,
                fmt::format("run a process: signal {} ended it{}", WTERMSIG(status),
                            memory ? ", as when it needs more than its memory limit" : ""));
  }
  nlohmann::json answer = nlohmann::json::parse(text, nullptr, false);
  if (!answer.is_object()) throw Error(ErrorCode::kIo, "run a process: it ended without a result");
  if (answer.contains("error"))
    throw Error(static_cast<ErrorCode>(answer["code"].get<int>()),
                answer["error"].get<std::string>());
  got.figures.peak_rss_bytes = answer["peak"].get<std::uint64_t>();
  got.result = std::move(answer["result"]);
  return got;
}

nlohmann::json in_own_process(const std::function<nlohmann::json()>& work) {
  return run_in_own_process(work).result;
}

std::uint64_t memory_status(const std::string& name) {
  std::ifstream status("/proc/self/status");
  std::string word;
  std::uint64_t kibibytes = 0;
  while (status >> word)
    if (word == name + ":") {
      status >> kibibytes;
      break;
    }
  return kibibytes * 1024;
}

PeakMemory::PeakMemory() {
  ::malloc_trim(0);
  std::ofstream("/proc/self/clear_refs") << "5";  // the peak counts from now on
  before_ = memory_status("VmRSS");
}

std::uint64_t PeakMemory::bytes() const {
  const std::uint64_t peak = memory_status("VmHWM");
  return peak > before_ ? peak - before_ : 0;
}

std::string output_of(const std::string& command) {
  std::FILE* const pipe = ::popen(command.c_str(), "r");
  if (!pipe) return {};
  std::string text;
  char buffer[4096];
  for (std::size_t got = 0; (got = std::fread(buffer, 1, sizeof(buffer), pipe)) > 0;)
    text.append(buffer, got);
  return ::pclose(pipe) == 0 ? text : std::string();
}

}  // namespace plait::instrument
