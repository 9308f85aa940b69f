#include "instrument/process.h"

#include <fmt/format.h>
#include <malloc.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <fstream>
#include <memory>

#include "instrument/memory_limit.h"
#include "plait/error.h"

namespace plait::instrument {
namespace {

double seconds_of(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

std::string rest_of(std::FILE* file) {
  std::string text;
  char part[4096];
  for (std::size_t got = 0; (got = std::fread(part, 1, sizeof part, file)) > 0;)
    text.append(part, got);
  return text;
}

/// Of this process, "VmHWM:" or "VmRSS:"; 0 if not known.
std::uint64_t memory_status(const std::string& name) {
  return number_in("/proc/self/status", name).value_or(0) * 1024;
}

/// What the child does: never returns.
[[noreturn]] void work_and_answer(std::FILE* to, pid_t parent,
                                  const std::function<nlohmann::json()>& work,
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
  answer["peak"] = memory_status("VmHWM:");
  std::fputs(answer.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace).c_str(), to);
  std::fflush(nullptr);
  ::_exit(0);
}

}  // namespace

ProcessResult run_in_own_process(const std::function<nlohmann::json()>& work,
                                 const MemoryLimit* limit) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> answers(
      ::fdopen(::memfd_create("answer", MFD_CLOEXEC), "w+"), std::fclose);
  if (!answers) throw system_error("make", "a file in memory", errno);
  std::fflush(nullptr);
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child < 0) throw system_error("start", "a process", errno);
  if (child == 0) work_and_answer(answers.get(), parent, work, limit);
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
  std::rewind(answers.get());
  nlohmann::json answer = nlohmann::json::parse(rest_of(answers.get()), nullptr, false);
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

std::optional<std::uint64_t> number_in(const std::filesystem::path& file,
                                       const std::string& after) {
  std::ifstream words(file);
  for (std::string word; word != after;)
    if (!(words >> word)) return std::nullopt;
  std::uint64_t number = 0;
  return words >> number ? std::optional(number) : std::nullopt;
}

PeakMemory::PeakMemory() {
  ::malloc_trim(0);
  std::ofstream("/proc/self/clear_refs") << "5";  // the peak counts from now on
  before_ = memory_status("VmRSS:");
}

std::uint64_t PeakMemory::bytes() const {
  const std::uint64_t peak = memory_status("VmHWM:");
  return peak > before_ ? peak - before_ : 0;
}

std::string output_of(const std::string& command) {
  std::FILE* const pipe = ::popen(command.c_str(), "r");
  if (!pipe) return {};
  std::string text = rest_of(pipe);
  return ::pclose(pipe) == 0 ? text : std::string();
}

}  // namespace plait::instrument
