#include "instrument/surroundings.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <utility>

namespace plait::instrument {
namespace {

constexpr std::array kPressures = {"cpu", "io", "memory"};

/// Seconds in which something waited: "some avg10=0.00 avg60=0.00 avg300=0.00 total=123".
std::optional<double> waited_for(const std::string& what) {
  std::ifstream file("/proc/pressure/" + what);
  for (std::string word; file >> word;)
    if (word.starts_with("total=")) return 1e-6 * std::stod(word.substr(6));
  return std::nullopt;
}

}  // namespace

nlohmann::ordered_json to_json(const Surroundings& surroundings) {
  nlohmann::ordered_json pressure;
  for (const auto& [name, value] : surroundings.pressure)
    pressure[name] = value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
  return {{"load", surroundings.load},
          {"others", surroundings.others},
          {"stolen", surroundings.stolen},
          {"pressure", std::move(pressure)}};
}

SurroundingsWatch::SurroundingsWatch() : start_(now()) {}

SurroundingsWatch::Counters SurroundingsWatch::now() {
  Counters found;
  // cpu user nice system idle iowait irq softirq steal guest guest_nice, in ticks; guests are in
  // user.
  std::ifstream file("/proc/stat");
  std::string name;
  file >> name;
  const double tick = 1 / static_cast<double>(::sysconf(_SC_CLK_TCK));
  double ticks = 0;
  for (int at = 0; at < 8 && file >> ticks; ++at) {
    found.all += ticks * tick;
    if (at < 2) found.user += ticks * tick;
    if (at == 7) found.stolen = ticks * tick;
  }
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  found.own = static_cast<double>(usage.ru_utime.tv_sec) +
              1e-6 * static_cast<double>(usage.ru_utime.tv_usec);
  for (std::size_t at = 0; at < kPressures.size(); ++at)
    found.waited[at] = waited_for(kPressures[at]);
  return found;
}

Surroundings SurroundingsWatch::since(double own_seconds) const {
  const Counters end = now();
  Surroundings found;
  std::ifstream("/proc/loadavg") >> found.load;
  const double all = end.all - start_.all;
  const double seconds = clock_.seconds();
  if (all > 0) {
    const double own = own_seconds + end.own - start_.own;
    found.others = std::max(0.0, end.user - start_.user - own) / all;
    found.stolen = std::max(0.0, end.stolen - start_.stolen) / all;
  }
  for (std::size_t at = 0; at < kPressures.size(); ++at) {
    std::optional<double>& pressure = found.pressure[kPressures[at]];
    if (start_.waited[at] && end.waited[at] && seconds > 0)
      pressure = (*end.waited[at] - *start_.waited[at]) / seconds;
  }
  return found;
}

}  // namespace plait::instrument
