#include "measure.h"

#include <sys/resource.h>

#include <fstream>
#include <string>

namespace plait {
namespace {

/// Constructed before main() begins. The time of the loader before that is a few milliseconds.
const Stopwatch kSinceStart;

double to_seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

}  // namespace

double seconds_since_start() { return kSinceStart.seconds(); }

double cpu_seconds() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return to_seconds(usage.ru_utime) + to_seconds(usage.ru_stime);
}

std::uint64_t peak_rss_bytes() {
  std::ifstream status("/proc/self/status");
  std::string word;
  std::uint64_t kibibytes = 0;
  while (status >> word)
    if (word == "VmHWM:") {
      status >> kibibytes;
      break;
    }
  return kibibytes * 1024;
}

}  // namespace plait
