// The suite over the built-in backends: compressed with each codec and filter, and every backend
// under a wrapper that must not be noticed.
#include "backends/conformance.h"

#include "plait/backends/registry.h"
#include "support/counting_backend.h"
#include "support/usable_backends.h"

namespace plait::test {
namespace {

void add_backends(std::vector<BackendUnderTest>& result, const BackendRegistry& registry,
                  const std::string& suffix) {
  for (const std::string& name : usable_backends()) {
    const BackendRegistry::Entry& entry = registry.find(name);
    if (!entry.traits.compressed) {
      result.push_back({name + suffix, entry, {}});
      continue;
    }
    for (const char* codec : {"none", "lz4", "zstd", "zstd:-5", "zstd:9"})
      for (const char* filter : {"none", "shuffle"})
        result.push_back({name + ' ' + codec + ' ' + filter + suffix, entry, {codec, filter}});
  }
}

}  // namespace

const std::vector<BackendUnderTest>& backends_under_test() {
  static const std::vector<BackendUnderTest> subjects = [] {
    static BackendCounts counts;
    std::vector<BackendUnderTest> result;
    add_backends(result, default_backends(), "");
    add_backends(result, counting_registry(default_backends(), counts), " (counted)");
    return result;
  }();
  return subjects;
}

}  // namespace plait::test
