#include "backends/read_runs.h"

#include <fmt/format.h>

#include <cerrno>
#include <fstream>
#include <limits>
#include <unordered_map>

#include "plait/error.h"

namespace plait::bench {
namespace {

using nlohmann::json;

constexpr std::size_t kMostSkippedLines = 10;

/// Calls use(text, number, why) for the lines of a file that are not empty; `why` says why a line
/// cannot be a record.
template <class Use>
void for_each_line(const std::filesystem::path& path, Use use) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw system_error("open", path.native(), errno);
  std::string buffer(kMostLineBytes + 1, '\0');
  for (std::uint64_t number = 1; !file.eof(); ++number) {
    file.getline(buffer.data(), static_cast<std::streamsize>(buffer.size()));
    const auto count = static_cast<std::size_t>(file.gcount());  // with the newline
    if (file.bad()) throw system_error("read", path.native(), EIO);
    std::string why;
    if (file.eof() && count > 0) why = "the line is not complete: its writer was stopped";
    if (file.fail() && !file.eof()) {
      why = fmt::format("expected at most {} bytes in a line", kMostLineBytes);
      file.clear();
      file.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
    }
    const std::string text = buffer.substr(0, count - (why.empty() && !file.eof() ? 1 : 0));
    if (!why.empty() || text.find_first_not_of(" \t\r") != std::string::npos)
      use(text, number, why);
  }
}

}  // namespace

RunSet read_runs(const std::vector<std::filesystem::path>& files) {
  RunSet set;
  std::unordered_map<std::string, std::size_t> runs_of_cell;
  for (const std::filesystem::path& path : files)
    for_each_line(path, [&](const std::string& text, std::uint64_t number, const std::string& why) {
      try {
        if (!why.empty()) throw BadRecord{why};
        const json record = json::parse(text, nullptr, false);
        if (record.is_discarded()) throw BadRecord{"not JSON"};
        MeasuredRun run = run_of_record(record);
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
      }
    });
  if (set.runs.empty())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("read {}", !set.skipped_lines.empty() ? set.skipped_lines.front()
                                       : files.empty()            ? "nothing"
                                                                  : files.front().native() +
                                                             ": expected runs, found none"));
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
