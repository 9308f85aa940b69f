#include "io/own_machine.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <random>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

OwnMachine find_own_machine() {
  constexpr std::size_t kMostOfHost = 32, kStart = 8;
  OwnMachine machine;
  std::array<char, 256> name{};
  machine.host = ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "host";
  machine.host.resize(std::min(machine.host.size(), kMostOfHost));
  for (char& c : machine.host)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '.') c = '_';
  if (machine.host.empty()) machine.host = "host";
  std::ifstream("/proc/sys/kernel/random/boot_id") >> machine.start;
  machine.start.resize(std::min(machine.start.size(), kStart));
  if (machine.start.empty()) machine.start = random_hex();
  return machine;
}

}  // namespace

const OwnMachine& own_machine() {
  static const OwnMachine machine = find_own_machine();
  return machine;
}

std::string random_hex() {
  std::random_device device;
  return fmt::format("{:08x}", device());
}

PLAIT_END_NAMESPACE
