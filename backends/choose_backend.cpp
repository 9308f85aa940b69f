#include "choose_backend.h"

#include <fmt/format.h>

#include <optional>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr const char* kUring = "uring";
constexpr const char* kPread = "pread";
constexpr const char* kMmap = "mmap";
constexpr const char* kMemory = "memory";
constexpr const char* kCompressed = "compressed";

std::string mebibytes(std::uint64_t bytes) {
  return bytes == ~std::uint64_t{0} ? "an unknown amount" : fmt::format("{} MiB", bytes >> 20);
}

struct DecidedByMedium {
  const char* name;
  std::string reason;
};

/// Nothing if the medium alone does not decide.
std::optional<DecidedByMedium> medium_choice(const BackendFacts& facts) {
  switch (facts.medium) {
    case StoreMedium::kMemory:
      if (!facts.no_mmap.empty()) return {{kPread, facts.no_mmap}};
      return {{kMmap, "its file system keeps files in memory"}};
    case StoreMedium::kNetwork:
      return {{kPread, "its files are on another machine"}};
    case StoreMedium::kUnknown:
      return {{kPread, "nothing is known of its disk"}};
    case StoreMedium::kDisk:
      break;
  }
  return {};
}

}  // namespace

BackendChoice choose_backend(const BackendFacts& facts) {
  if (facts.in_memory) return {kMemory, "the store has no path, so it is only in memory"};
  if (facts.has_pipelines) return {kCompressed, "the store has pipelines"};
  const bool large = facts.level_bytes > facts.available_bytes / kLargeStoreDivisor;
  const std::string size = fmt::format(
      "the store is {} compared with the memory ({} of levels, {} of memory available)",
      large ? "large" : "small", mebibytes(facts.level_bytes), mebibytes(facts.available_bytes));
  if (const auto medium = medium_choice(facts))
    return {medium->name, fmt::format("{}{} {}", size, large ? ", but" : ", and", medium->reason)};
  if (!large) return {kPread, size + ", so the page cache keeps it"};
  for (const std::string* const refusal : {&facts.no_uring, &facts.no_direct})
    if (!refusal->empty()) return {kPread, fmt::format("{}, but {}", size, *refusal)};
  return {kUring, size + ", so it goes past the page cache"};
}

BackendChoice choose_backend(const BackendRegistry& backends, const NewStore& store) {
  return choose_backend(backend_facts(backends, store));
}

PLAIT_END_NAMESPACE
