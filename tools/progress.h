// tools/progress.h: draws a progress bar on standard error, and tells the work about Ctrl-C.
// Nothing is drawn unless standard error is a terminal.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

namespace plait {

/// The unit of the counts, for the rate.
enum class ProgressUnit : std::uint8_t { kVertices, kBytes, kNone };

/// For one thread. The bar is drawn at most ten times per second, and removed at the end.
class ProgressBar {
 public:
  ProgressBar(std::string task, ProgressUnit unit);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// Returns false after a signal, as a progress callback should.
  bool update(std::uint64_t done, std::uint64_t total, std::string_view phase = {});
  /// Removes the bar. Call this before printing anything else.
  void clear();

 private:
  using Clock = std::chrono::steady_clock;
  std::string task_;
  ProgressUnit unit_;
  bool terminal_;
  bool drawn_ = false;
  Clock::time_point start_, last_;
};

/// The bar as text, at most `columns` wide:
/// "subdivide  level 3: odd vertices [#####.....]  42%  12.3 M vertices/s  0:07 left".
std::string progress_line(std::string_view task, std::string_view phase, ProgressUnit unit,
                          std::uint64_t done, std::uint64_t total, double seconds,
                          std::size_t columns);

}  // namespace plait
