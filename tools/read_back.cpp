#include "read_back.h"

#include <fcntl.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <utility>

#include "plait/digest.h"
#include "plait/error.h"
#include "plait/file.h"
#include "plait/level_cursor.h"
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

/// The largest error of a record, and whether all errors are within the bound. A number that kept
/// its bits has no error, also if it is no number.
template <class Number>
bool is_within(std::span<const std::byte> before, std::span<const std::byte> after,
               std::size_t components, const ErrorBound& bound, long double most) {
  for (std::size_t at = 0; at < before.size(); at += components * sizeof(Number)) {
    long double sum = 0, largest = 0;
    for (std::size_t i = 0; i < components; ++i) {
      Number from, to;
      std::memcpy(&from, before.data() + at + i * sizeof from, sizeof from);
      std::memcpy(&to, after.data() + at + i * sizeof to, sizeof to);
      if (std::memcmp(&from, &to, sizeof from) == 0) continue;
      const long double error =
          std::abs(static_cast<long double>(from) - static_cast<long double>(to));
      sum += error * error;
      largest = error <= largest ? largest : error;
    }
    const long double found = bound.metric == ErrorMetric::kEuclidean ? std::sqrt(sum) : largest;
    if (!(found <= most)) return false;
  }
  return true;
}

void compare_attribute(Store& source, AttributeId id, Store& copy,
                       const std::optional<ErrorBound>& bound, Progress& progress) {
  const AttributeSchema& schema = source.attributes()[id].schema;
  const AttributeId other = copy.attribute(schema.name);
  const auto refuse = [&](int level, EdgeId edge) {
    return Error(
        ErrorCode::kCorruption,
        fmt::format("read back {}: expected records of '{}' {} those of {}, found another "
                    "in the slot of edge {} of level {}",
                    copy.path().native(), schema.name, bound ? "within the bound of" : "equal to",
                    source.path().native(), edge, level));
  };
  const auto base = std::as_const(source).base_bytes(id);
  if (!std::ranges::equal(base, std::as_const(copy).base_bytes(other)))
    throw refuse(source.base_level(), 0);
  std::optional<Rounder> rounder;
  if (bound) rounder.emplace(schema, *bound, base);
  const long double most = rounder ? rounder->result().bound : 0;
  const auto edges = static_cast<EdgeId>(source.base().edge_count());
  for (int level = source.base_level() + 1; level <= source.attributes()[id].finest_level;
       ++level) {
    LevelCursor from(source.open_session(), source.level_file(id, level));
    LevelCursor to(copy.open_session(), copy.level_file(other, level));
    for (EdgeId edge = 0; edge < edges; ++edge) {
      const std::span<const std::byte> before = from.slot(edge).bytes, after = to.slot(edge).bytes;
      const bool right = !bound ? std::ranges::equal(before, after)
                         : schema.type == ComponentType::kFloat32
                             ? is_within<float>(before, after, schema.components, *bound, most)
                             : is_within<double>(before, after, schema.components, *bound, most);
      if (!right) throw refuse(level, edge);
      progress.update(edge, edges, schema.name);
    }
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
    Progress progress("compare with the source", ProgressUnit::kNone);
    for (AttributeId id = 0; id < source.attributes().size(); ++id)
      compare_attribute(source, id, opened, bounds.of(source.attributes()[id].schema.name),
                        progress);
  }
  return digest_with_progress(opened, "digest of the copy", threads);
}

}  // namespace plait
