#include "conversion/read_back.h"

#include <fcntl.h>
#include <fmt/format.h>

#include <utility>

#include "maintenance/compare_attribute.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/extend/file.h"
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

void begin(const ConversionWatch& watch, ConversionStep step) {
  if (watch.step) watch.step(step);
}

std::string watched_digest(Store& store, ConversionStep step, int threads,
                           const ConversionWatch& watch) {
  begin(watch, step);
  DigestOptions options;
  options.threads = threads;
  options.progress = watch.progress;
  return digest(store, options).to_string();
}

}  // namespace

std::string compare_copy(Store& source, const std::filesystem::path& copy, const OpenOptions& open,
                         int threads, const BackendRegistry& backends,
                         const ConversionWatch& watch) {
  drop_from_page_cache(copy);
  Store opened = Store::open(copy, open, backends);
  std::string found = watched_digest(opened, ConversionStep::kReadBack, threads, watch);
  const std::string expected =
      watched_digest(source, ConversionStep::kSourceDigest, threads, watch);
  if (found != expected)
    throw Error(ErrorCode::kCorruption,
                fmt::format("read back {}: expected digest {} of {}, found {}", copy.native(),
                            expected, source.path().native(), found));
  return found;
}

std::string compare_rounded_copy(Store& source, const std::filesystem::path& copy,
                                 const OpenOptions& open, int threads,
                                 const BackendRegistry& backends, const ErrorBounds& bounds,
                                 const ConversionWatch& watch) {
  drop_from_page_cache(copy);
  Store opened = Store::open(copy, open, backends);
  begin(watch, ConversionStep::kReadBack);
  std::uint64_t done = 0, total = 0;
  for (AttributeId id = 0; id < source.attributes().size(); ++id)
    total += bytes_of_levels(source, id);
  for (AttributeId id = 0; id < source.attributes().size(); ++id) {
    const std::string& name = source.attributes()[id].schema.name;
    compare_attribute(source, id, opened, opened.attribute(name), bounds.of(name),
                      [&](const Progress& now) {
                        return !watch.progress || watch.progress({name, done + now.done, total});
                      });
    done += bytes_of_levels(source, id);
  }
  return watched_digest(opened, ConversionStep::kSourceDigest, threads, watch);
}

PLAIT_END_NAMESPACE
