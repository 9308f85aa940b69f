#include "confined.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <system_error>

#include "plait/error.h"
#include "plait/file.h"

namespace plait::bench {
namespace {

namespace fs = std::filesystem;

bool put(const fs::path& path, const std::string& text) {
  std::ofstream file(path);
  file << text << std::flush;
  return file.good();
}

}  // namespace

MemoryLimit::MemoryLimit(std::uint64_t bytes) {
  const fs::path group =
      fs::path("/sys/fs/cgroup/memory") / fmt::format("plait-bench-{}", ::getpid());
  std::error_code failed;
  if (!fs::exists("/sys/fs/cgroup/memory/memory.limit_in_bytes", failed) ||
      !fs::create_directory(group, failed))
    return;
  if (put(group / "memory.limit_in_bytes", std::to_string(bytes)))
    group_ = group;
  else
    fs::remove(group, failed);
}

MemoryLimit::~MemoryLimit() {
  if (limited()) ::rmdir(group_.c_str());
}

double MemoryLimit::run(const std::function<double()>& work) const {
  return run_for_figures([&] { return std::vector<double>{work()}; }).at(0);
}

std::vector<double> MemoryLimit::run_for_figures(
    const std::function<std::vector<double>()>& work) const {
  constexpr std::size_t kMost = 256;  // a pipe takes so many at once
  int ends[2];
  if (::pipe(ends) != 0) throw system_error("make", "a pipe", errno);
  std::fflush(nullptr);
  const pid_t child = ::fork();
  if (child < 0) throw system_error("start", "a child process", errno);
  if (child == 0) {
    int status = 1;
    try {
      if (limited() && !put(group_ / "cgroup.procs", std::to_string(::getpid())))
        throw Error(ErrorCode::kIo, "enter " + group_.native() + ": refused");
      const std::vector<double> results = work();
      const std::size_t bytes = results.size() * sizeof(double);
      if (results.size() <= kMost &&
          ::write(ends[1], results.data(), bytes) == static_cast<ssize_t>(bytes))
        status = 0;
    } catch (const std::exception& error) {
      fmt::print(stderr, "{}\n", error.what());
    }
    ::_exit(status);
  }
  ::close(ends[1]);
  std::vector<double> results(kMost);
  const ssize_t got = ::read(ends[0], results.data(), kMost * sizeof(double));
  ::close(ends[0]);
  int status = 0;
  ::waitpid(child, &status, 0);
  if (got <= 0 || status != 0) throw Error(ErrorCode::kIo, "measure: the child process failed");
  results.resize(static_cast<std::size_t>(got) / sizeof(double));
  return results;
}

bool make_cold(const std::vector<fs::path>& files) {
  ::sync();
  if (put("/proc/sys/vm/drop_caches", "3")) return true;
  for (const fs::path& path : files) {
    const File file(path, OpenMode::kRead);
    ::posix_fadvise(file.descriptor(), 0, 0, POSIX_FADV_DONTNEED);
  }
  return false;
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

}  // namespace plait::bench
