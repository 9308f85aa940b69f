#include "conversion/read_back.h"

#include <fcntl.h>
#include <fmt/format.h>

#include <utility>

#include "job_rules.h"
#include "maintenance/compare_attribute.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/extend/file.h"
#include "prune/compare_pruned.h"
#include "store/attribute_levels.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Removes the pages of the store's files from the page cache, if they are on the disk already.
void drop_from_page_cache(const std::filesystem::path& store) {
  for (const auto& entry : std::filesystem::directory_iterator(store)) {
    if (!entry.is_regular_file()) continue;
    const File file(entry.path(), OpenMode::kRead);
    ::posix_fadvise(file.descriptor(), 0, 0, POSIX_FADV_DONTNEED);
  }
}

std::string watched_digest(Store& store, std::string_view step, int threads,
                           const JobWatch& watch) {
  DigestOptions options;
  options.threads = threads;
  options.progress = begin_step(watch, step);
  options.begins = [&](int taken) {
    warn_of_fewer_threads(step, taken, threads, store.options().budget_bytes, watch.warn);
  };
  return digest(store, options).to_string();
}

}  // namespace

ProgressCallback begin_step(const JobWatch& watch, std::string_view step) {
  if (watch.step) watch.step(step);
  if (!watch.progress) return {};
  return [&watch, step](const Progress& now) {
    return watch.progress({step, now.done, now.total});
  };
}

std::string compare_copy(Store& source, const std::filesystem::path& copy, const OpenOptions& open,
                         int threads, const BackendRegistry& backends, const JobWatch& watch) {
  drop_from_page_cache(copy);
  Store opened = Store::open(copy, open, backends);
  std::string found = watched_digest(opened, "read the copy back", threads, watch);
  const std::string expected = watched_digest(source, "digest of the source", threads, watch);
  if (found != expected)
    throw Error(ErrorCode::kCorruption,
                fmt::format("read back {}: expected digest {} of {}, found {}", copy.native(),
                            expected, source.path().native(), found));
  return found;
}

std::string compare_rounded_copy(Store& source, const std::filesystem::path& copy,
                                 const OpenOptions& open, int threads,
                                 const BackendRegistry& backends, const ErrorBounds& bounds,
                                 const JobWatch& watch) {
  drop_from_page_cache(copy);
  Store opened = Store::open(copy, open, backends);
  const ProgressCallback progress = begin_step(watch, "read the copy back");
  std::uint64_t done = 0, total = 0;
  for (AttributeId id = 0; id < source.attributes().size(); ++id)
    total += bytes_of_levels(source, id);
  for (AttributeId id = 0; id < source.attributes().size(); ++id) {
    const std::string& name = source.attributes()[id].schema.name;
    compare_attribute(source, id, opened, opened.attribute(name), bounds.of(name),
                      [&](const Progress& now) {
                        return !progress || progress({name, done + now.done, total});
                      });
    done += bytes_of_levels(source, id);
  }
  return watched_digest(opened, "digest of the source", threads, watch);
}

std::string compare_filled_copy(Store& source, const std::filesystem::path& copy,
                                const OpenOptions& open, int threads,
                                const BackendRegistry& backends, const JobWatch& watch) {
  drop_from_page_cache(copy);
  Store opened = Store::open(copy, open, backends);
  const PrunedComparison found =
      compare_pruned(source, opened, begin_step(watch, "read the copy back"));
  if (found.difference)
    throw Error(ErrorCode::kCorruption,
                fmt::format("read back {}: expected the records of {}: {}", copy.native(),
                            source.path().native(), *found.difference));
  return watched_digest(opened, "digest of the copy", threads, watch);
}

PLAIT_END_NAMESPACE
