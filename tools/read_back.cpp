#include "read_back.h"

#include <fcntl.h>
#include <fmt/format.h>

#include <utility>

#include "plait/attribute_levels.h"
#include "plait/compare_attribute.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/file.h"
#include "progress.h"

namespace plait {
namespace {

/// Removes the pages of the store's files from the page cache, if they are on the disk already.
void drop_from_page_cache(const std::filesystem::path& store) {
  for (const auto& entry : std::filesystem::directory_iterator(store)) {
    if (!entry.is_regular_file()) continue;
    const File file(entry.path(), OpenMode::kRead);
    ::posix_fadvise(file.descriptor(), 0, 0, POSIX_FADV_DONTNEED);
  }
}

}  // namespace

std::string digest_with_progress(Store& store, std::string task, int threads) {
  Progress progress(std::move(task), ProgressUnit::kNone);
  DigestOptions options;
  options.threads = threads;
  options.proceed = [&](std::uint64_t done, std::uint64_t total) {
    return progress.update(done, total);
  };
  return digest(store, options).to_string();
}

std::string compare_copy(Store& source, const std::filesystem::path& copy, const OpenOptions& open,
                         int threads, const BackendRegistry& backends) {
  drop_from_page_cache(copy);
  Store opened = Store::open(copy, open, backends);
  std::string found = digest_with_progress(opened, "read the copy back", threads);
  const std::string expected = digest_with_progress(source, "digest of the source", threads);
  if (found != expected)
    throw Error(ErrorCode::kCorruption,
                fmt::format("read back {}: expected digest {} of {}, found {}", copy.native(),
                            expected, source.path().native(), found));
  return found;
}

std::string compare_rounded_copy(Store& source, const std::filesystem::path& copy,
                                 const OpenOptions& open, int threads,
                                 const BackendRegistry& backends, const ErrorBounds& bounds) {
  drop_from_page_cache(copy);
  Store opened = Store::open(copy, open, backends);
  {
    Progress progress("compare with the source", ProgressUnit::kBytes);
    std::uint64_t done = 0, total = 0;
    for (AttributeId id = 0; id < source.attributes().size(); ++id)
      total += bytes_of_levels(source, id);
    for (AttributeId id = 0; id < source.attributes().size(); ++id) {
      const std::string& name = source.attributes()[id].schema.name;
      // What is computed from rounded records has changed with them.
      if (!opened.derivation(opened.attribute(name)).empty()) continue;
      compare_attribute(
          source, id, opened, opened.attribute(name), bounds.of(name),
          [&](std::uint64_t compared) { return progress.update(done += compared, total, name); });
    }
  }
  return digest_with_progress(opened, "digest of the copy", threads);
}

}  // namespace plait
