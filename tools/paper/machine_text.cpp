#include "paper/machine_text.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/utsname.h>

#include <chrono>
#include <ctime>
#include <fstream>
#include <iterator>
#include <string_view>
#include <thread>

#include "instrument/disk.h"

namespace plait::paper {
namespace {

std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name"))
      if (const std::size_t colon = line.find(": "); colon != std::string::npos)
        return line.substr(colon + 2);
  return "unknown processor";
}

std::string for_shell(const std::string& word) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_./,:=+@%";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string text = "'";
  for (const char character : word)
    if (character == '\'')
      text += "'\\''";
    else
      text += character;
  text += '\'';
  return text;
}

}  // namespace

std::string machine_text(const std::filesystem::path& directory) {
  utsname names{};
  ::uname(&names);
  return fmt::format("{} x {}, {} {}, {}", std::thread::hardware_concurrency(), processor_name(),
                     names.sysname, names.release, instrument::disk_facts(directory).name());
}

std::string date_text() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  return fmt::format("{:%Y-%m-%d}", fmt::gmtime(now));
}

std::string command_text() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  std::string text, word;
  for (bool first = true; std::getline(file, word, '\0'); first = false)
    text += first ? std::string("plait") : fmt::format(" {}", for_shell(word));
  return text;
}

}  // namespace plait::paper
