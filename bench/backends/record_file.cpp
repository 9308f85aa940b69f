#include "backends/record_file.h"

#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <utility>

#include "plait/error.h"

namespace plait::bench {

namespace fs = std::filesystem;

RecordFile::RecordFile(fs::path path) : path_(std::move(path)) {
  std::error_code failed;
  // Of a link itself: one that leads nowhere is refused too, or its target would be made.
  const fs::file_status status = fs::symlink_status(path_, failed);
  if (path_.empty() || !fs::exists(status)) return;
  if (!fs::is_regular_file(status))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("continue {}: it is no regular file", path_.native()));
  std::ifstream file(path_, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  std::size_t line = 0, end = 0;
  for (std::size_t at = 0; (end = text.find('\n', at)) != std::string::npos; at = end + 1) {
    ++line;
    auto record = nlohmann::ordered_json::parse(text.substr(at, end - at), nullptr, false);
    if (!record.is_object() || record.value("format", "") != "plait-bench-1")
      throw Error(
          ErrorCode::kInvalidArgument,
          fmt::format("continue {}: line {} is no record of plait bench", path_.native(), line));
    records_.push_back(std::move(record));
  }
  const std::size_t last = text.rfind('\n');
  const std::size_t whole = last == std::string::npos ? 0 : last + 1;
  if (whole == text.size()) return;
  // An interrupted run left the beginning of a record; anything else is not ours to cut off.
  if (!text.substr(whole).starts_with("{\"format\":\"plait-bench-1\""))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("continue {}: its end is no record of plait bench", path_.native()));
  fs::resize_file(path_, whole);
}

void RecordFile::append(nlohmann::ordered_json record) {
  if (!path_.empty()) {
    std::ofstream file(path_, std::ios::binary | std::ios::app);
    file << record.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) << '\n'
         << std::flush;
    if (!file.good()) throw Error(ErrorCode::kIo, "write " + path_.native() + ": refused");
  }
  records_.push_back(std::move(record));
}

}  // namespace plait::bench
