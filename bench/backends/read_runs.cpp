#include "backends/read_runs.h"

#include <fmt/format.h>

#include <algorithm>
#include <unordered_map>

#include "backends/record_members.h"
#include "backends/run_of_record.h"
#include "plait/error.h"
#include "plait/extend/file.h"

namespace plait::bench {
namespace {

using nlohmann::json;

constexpr std::size_t kMostSkippedLines = 10;

/// The lines of a file, one at a time. A line that is too long is passed over.
class Lines {
 public:
  explicit Lines(const std::filesystem::path& path)
      : file_(path, OpenMode::kRead), left_(file_.size()), buffer_(1 << 18, '\0') {}

  /// Returns false at the end. `complete`: a newline ended it; `too_long`: `line` is only its
  /// start.
  bool next(std::string& line, bool& complete, bool& too_long) {
    line.clear();
    complete = too_long = false;
    bool any = false;
    for (;;) {
      if (at_ == end_ && !fill()) return any;
      any = true;
      const char* const first = buffer_.data() + at_;
      const std::size_t available = end_ - at_;
      const auto* const newline = std::find(first, first + available, '\n');
      const auto length = static_cast<std::size_t>(newline - first);
      if (line.size() + length > kMostLineBytes) too_long = true;
      if (!too_long) line.append(first, length);
      at_ += length;
      if (length == available) continue;
      ++at_;
      complete = true;
      return true;
    }
  }

 private:
  bool fill() {
    at_ = 0;
    end_ = static_cast<std::size_t>(std::min<std::uint64_t>(left_, buffer_.size()));
    if (end_ == 0) return false;
    file_.read_at(offset_, std::as_writable_bytes(std::span(buffer_).first(end_)));
    offset_ += end_;
    left_ -= end_;
    return true;
  }

  File file_;
  std::uint64_t offset_ = 0, left_;
  std::string buffer_;
  std::size_t at_ = 0, end_ = 0;
};

}  // namespace

RunSet read_runs(const std::vector<std::filesystem::path>& files) {
  RunSet set;
  std::unordered_map<std::string, std::size_t> runs_of_cell;
  for (const std::filesystem::path& path : files) {
    Lines lines(path);
    std::string line;
    bool complete = false;
    bool too_long = false;
    for (std::uint64_t number = 1; lines.next(line, complete, too_long); ++number) {
      if (complete && !too_long && line.find_first_not_of(" \t\r") == std::string::npos) continue;
      try {
        if (too_long)
          throw BadRecord{fmt::format("expected at most {} bytes in a line", kMostLineBytes)};
        if (!complete) throw BadRecord{"the line is not complete: its writer was stopped"};
        MeasuredRun run = run_of_record(json::parse(line));
        if (set.runs.size() == kMostRuns)
          throw BadRecord{fmt::format("expected at most {} runs", kMostRuns)};
        if (++runs_of_cell[run.key] > kMostRunsOfCell)
          throw BadRecord{fmt::format("expected at most {} runs of a cell", kMostRunsOfCell)};
        run.file = cut(path.native());
        run.line = number;
        set.runs.push_back(std::move(run));
      } catch (const BadRecord& bad) {
        ++set.skipped;
        if (set.skipped_lines.size() < kMostSkippedLines)
          set.skipped_lines.push_back(
              fmt::format("{}:{}: {}", cut(path.native()), number, bad.why));
      } catch (const json::exception&) {
        ++set.skipped;
        if (set.skipped_lines.size() < kMostSkippedLines)
          set.skipped_lines.push_back(fmt::format("{}:{}: not JSON", cut(path.native()), number));
      }
    }
  }
  if (set.runs.empty()) {
    const std::string place =
        set.skipped_lines.empty()
            ? (files.empty() ? std::string()
                             : files.front().native() + ": expected runs, found none")
            : set.skipped_lines.front();
    throw Error(ErrorCode::kInvalidArgument, fmt::format("read {}", place));
  }
  return set;
}

RunSet runs_of(const std::vector<nlohmann::ordered_json>& records, const std::string& name) {
  RunSet set;
  for (const nlohmann::ordered_json& record : records) {
    try {
      set.runs.push_back(run_of_record(json::parse(record.dump())));
    } catch (const BadRecord& bad) {
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("{}:{}: {}", name, set.runs.size() + 1, bad.why));
    }
    set.runs.back().file = name;
    set.runs.back().line = set.runs.size();
  }
  return set;
}

}  // namespace plait::bench
