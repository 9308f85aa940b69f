#include "micro/support.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "instrument/statistics.h"

namespace plait::bench {

using instrument::TableCell;

TableCell number(double value, int digits) {
  return {fmt::format("{:.{}f}", value, digits), value};
}

TableCell middle(std::span<const double> values, double scale, int digits) {
  return number(instrument::median(values) * scale, digits);
}

TableCell spread(std::span<const double> values, double scale, int digits) {
  TableCell cell = middle(values, scale, digits);
  const auto [least, most] = std::ranges::minmax(values);
  cell.text += fmt::format(" ({:.{}f} to {:.{}f})", least * scale, digits, most * scale, digits);
  return cell;
}

void print_table(const std::string& about, const instrument::Table& table) {
  std::fputs((about + "\n\n" + to_markdown(table)).c_str(), stdout);
}

void say_progress(const std::string& text) {
  if (::isatty(STDERR_FILENO) == 1) std::fputs((text + "\n").c_str(), stderr);
}

}  // namespace plait::bench
