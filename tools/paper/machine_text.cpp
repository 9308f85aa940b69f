#include "paper/machine_text.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/utsname.h>

#include <chrono>
#include <ctime>
#include <fstream>
#include <iterator>
#include <thread>

#include "argument_text.h"
#include "instrument/disk.h"
#include "instrument/processor.h"

namespace plait::paper {

std::string machine_text(const std::filesystem::path& directory) {
  utsname names{};
  ::uname(&names);
  const std::string processor = instrument::processor_name();
  return fmt::format("{} x {}, {} {}, {}", std::thread::hardware_concurrency(),
                     processor.empty() ? "unknown processor" : processor, names.sysname,
                     names.release, instrument::disk_facts(directory).name());
}

std::string date_text() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  return fmt::format("{:%Y-%m-%d}", fmt::gmtime(now));
}

std::string command_text() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  std::string text, word;
  for (bool first = true; std::getline(file, word, '\0'); first = false)
    text += first ? std::string("plait") : fmt::format(" {}", shell_word(word));
  return text;
}

}  // namespace plait::paper
