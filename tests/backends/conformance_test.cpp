// The suite over the built-in backends: compressed with each codec and filter, every backend under
// a wrapper that must not be noticed, and those that overwrite in place under the rollback journal.
#include "backends/conformance.h"

#include "plait/backends/registry.h"
#include "support/counting_backend.h"
#include "support/journaled_volume.h"
#include "support/usable_backends.h"

namespace plait::test {
namespace {

void add_backends(std::vector<BackendUnderTest>& result, const BackendRegistry& registry,
                  const std::string& suffix) {
  for (const std::string& name : usable_backends()) {
    const BackendRegistry::Entry& entry = registry.find(name);
    if (!entry.traits.compressed) {
      result.push_back({name + suffix, entry});
      continue;
    }
    for (const char* codec : {"none", "lz4", "zstd", "zstd:-5", "zstd:9"})
      for (const char* filter : {"none", "shuffle"}) {
        const std::string pipeline = std::string(filter) + ',' + codec;
        result.push_back({name + ' ' + pipeline + suffix, entry, pipeline});
      }
  }
}

}  // namespace

const std::vector<BackendUnderTest>& backends_under_test() {
  static const std::vector<BackendUnderTest> subjects = [] {
    static BackendCounts counts;
    std::vector<BackendUnderTest> result;
    add_backends(result, default_backends(), "");
    add_backends(result, counting_registry(default_backends(), counts), " (counted)");
    for (const std::string& name : usable_backends())
      if (const auto& entry = default_backends().find(name); entry.traits.overwrites_in_place)
        result.push_back({name + " (journaled)", journaled(entry)});
    return result;
  }();
  return subjects;
}

}  // namespace plait::test
