// bench/backends/record_file.h: the file of records, one JSON object a line (docs/bench.md).
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace plait::bench {

/// Appends records. Each line is on its way to the disk when append() returns, so that an
/// interruption loses at most the run that it interrupts.
class RecordFile {
 public:
  /// Reads the records that are there, and cuts off a last line without a newline. With an empty
  /// path records are only kept in memory. Errors: kIo; kInvalidArgument for a file with another
  /// line than a record, which is not touched.
  explicit RecordFile(std::filesystem::path path);
  void append(nlohmann::ordered_json record);
  const std::vector<nlohmann::ordered_json>& records() const { return records_; }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  std::vector<nlohmann::ordered_json> records_;
};

}  // namespace plait::bench
