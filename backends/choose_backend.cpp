#include "plait/backends/choose_backend.h"

#include <fmt/format.h>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr const char* kUring = "uring";
constexpr const char* kPread = "pread";

std::string mebibytes(std::uint64_t bytes) {
  return bytes == ~std::uint64_t{0} ? "an unknown amount" : fmt::format("{} MiB", bytes >> 20);
}

/// Why the medium alone decides; empty if it does not.
const char* medium_reason(StoreMedium medium) {
  switch (medium) {
    case StoreMedium::kMemory:
      return "its file system keeps files in memory";
    case StoreMedium::kNetwork:
      return "its files are on another machine";
    case StoreMedium::kUnknown:
      return "nothing is known of its disk";
    case StoreMedium::kDisk:
      break;
  }
  return "";
}

}  // namespace

BackendChoice choose_backend(const BackendFacts& facts) {
  const bool large = facts.raw_bytes > facts.available_bytes / kLargeStoreDivisor;
  const std::string size = fmt::format(
      "the store is {} compared with the memory ({} of levels, {} of memory available)",
      large ? "large" : "small", mebibytes(facts.raw_bytes), mebibytes(facts.available_bytes));
  if (const std::string medium = medium_reason(facts.medium); !medium.empty())
    return {kPread, fmt::format("{}{} {}", size, large ? ", but" : ", and", medium)};
  if (!large) return {kPread, size + ", so the page cache keeps it"};
  for (const std::string* const refusal : {&facts.no_uring, &facts.no_direct})
    if (!refusal->empty()) return {kPread, fmt::format("{}, but {}", size, *refusal)};
  return {kUring, size + ", so it goes past the page cache"};
}

BackendChoice choose_backend(const BackendRegistry& backends, const std::filesystem::path& path,
                             std::uint64_t raw_bytes, std::uint64_t available_bytes) {
  return choose_backend(backend_facts(backends, path, raw_bytes, available_bytes));
}

PLAIT_END_NAMESPACE
