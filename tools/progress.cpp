#include "progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "interrupt.h"

namespace plait {
namespace {

constexpr auto kRedrawInterval = std::chrono::milliseconds(100);
constexpr std::size_t kDefaultColumns = 80;
constexpr std::size_t kBarColumns = 24;

std::size_t terminal_columns() {
  winsize size{};
  if (::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return kDefaultColumns;
  return size.ws_col;
}

std::string rate_text(ProgressUnit unit, double per_second) {
  if (unit == ProgressUnit::kNone) return {};
  const char* name = unit == ProgressUnit::kBytes ? "B/s" : "vertices/s";
  const char* prefix = unit == ProgressUnit::kBytes ? "" : " ";
  if (per_second >= 1e9) return fmt::format("  {:.2f} G{}{}", per_second * 1e-9, prefix, name);
  if (per_second >= 1e6) return fmt::format("  {:.1f} M{}{}", per_second * 1e-6, prefix, name);
  return fmt::format("  {:.0f} k{}{}", per_second * 1e-3, prefix, name);
}

std::string time_text(double seconds) {
  const auto whole = static_cast<std::uint64_t>(std::clamp(seconds, 0.0, 1e7));
  if (whole >= 3600)
    return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
  return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

}  // namespace

std::string progress_line(std::string_view task, std::string_view phase, ProgressUnit unit,
                          std::uint64_t done, std::uint64_t total, double seconds,
                          std::size_t columns) {
  const double share =
      total == 0 ? 0 : std::min(1.0, static_cast<double>(done) / static_cast<double>(total));
  const auto filled = static_cast<std::size_t>(share * static_cast<double>(kBarColumns));
  std::string line =
      fmt::format("{}{}{} [{:#<{}}{:.<{}}] {:3.0f}%", task, phase.empty() ? "" : "  ", phase, "",
                  filled, "", kBarColumns - filled, 100 * share);
  if (share > 0 && seconds > 0) {
    line += rate_text(unit, static_cast<double>(done) / seconds);
    line += fmt::format("  {} left", time_text(seconds * (1 - share) / share));
  }
  if (line.size() > columns) line.resize(columns);
  return line;
}

ProgressBar::ProgressBar(std::string task, ProgressUnit unit)
    : task_(std::move(task)),
      unit_(unit),
      terminal_(::isatty(STDERR_FILENO) == 1),
      start_(Clock::now()),
      last_(start_) {}

ProgressBar::~ProgressBar() { clear(); }

bool ProgressBar::update(std::uint64_t done, std::uint64_t total, std::string_view phase) {
  if (interrupted()) return false;
  if (!terminal_) return true;
  const Clock::time_point now = Clock::now();
  if (now - last_ < kRedrawInterval) return true;
  last_ = now;
  const double seconds = std::chrono::duration<double>(now - start_).count();
  const std::string line =
      progress_line(task_, phase, unit_, done, total, seconds, terminal_columns() - 1);
  std::fprintf(stderr, "\r\033[K%s", line.c_str());
  std::fflush(stderr);
  drawn_ = true;
  return true;
}

void ProgressBar::clear() {
  if (!drawn_) return;
  std::fputs("\r\033[K", stderr);
  std::fflush(stderr);
  drawn_ = false;
}

}  // namespace plait
