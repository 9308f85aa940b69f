#include "io/made_mark.h"

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "plait/error.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::string_view kContent =
    "\x89plait\r\n"
    "plait made this directory for an output. If the run was killed, plait clean removes it.\n";

constexpr std::string_view kKeptContent =
    "This store is complete. It could not be renamed: copy it under another name, without this "
    "file.\n";

void write_mark(const Directory& directory, const char* name, std::string_view content) {
  File mark(directory, name, OpenMode::kCreate);
  mark.write_at(0, std::as_bytes(std::span(content)));
  mark.close();
}

}  // namespace

void write_made_mark(const Directory& directory) { write_mark(directory, kMadeMarkName, kContent); }

void write_kept_mark(const Directory& directory) {
  write_mark(directory, kKeptMarkName, kKeptContent);
}

bool has_made_mark(const Directory& directory) {
  try {
    const std::optional<File> mark = open_if_present(directory, kMadeMarkName, OpenMode::kRead);
    if (!mark || mark->size() > kContent.size()) return false;
    std::string found(mark->size(), '\0');
    mark->read_at(0, std::as_writable_bytes(std::span(found)));
    // A process that was killed while it wrote the mark had made nothing else yet.
    return found == kContent || (kContent.starts_with(found) &&
                                 directory.names() == std::vector<std::string>{kMadeMarkName});
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kCorruption) throw;
    return false;  // no regular file
  }
}

PLAIT_END_NAMESPACE
