// The suite over the built-in backends: compressed with each codec and filter, every backend under
// a wrapper that must not be noticed.
#include <array>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "conformance/suite.h"
#include "durability/faults.h"
#include "plait/registry.h"
#include "support/counting_backend.h"
#include "support/sanitized.h"
#include "support/usable_backends.h"

namespace plait::test {
namespace {

using Subjects = std::vector<conformance::Subject>;

void add_backends(Subjects& result, const BackendRegistry& registry, const std::string& suffix,
                  const std::vector<std::string>& pipelines) {
  for (const std::string& name : usable_backends()) {
    const RegisteredBackend& entry = registry.find(name);
    if (!entry.traits.compressed) {
      result.push_back({name + suffix, entry});
      continue;
    }
    for (const std::string& pipeline : pipelines) {
      conformance::Subject subject{name + ' ' + pipeline + suffix, entry, pipeline};
      subject.make_codec = [codec = subject.pipeline.codec] {
        return default_pipelines().make_codec(codec);
      };
      subject.codec_blocks = unless_sanitized(300, 60);
      result.push_back(std::move(subject));
    }
  }
}

Subjects backends_under_test() {
  static BackendCounts counts;
  Subjects result;
  add_backends(result, default_backends(), "",
               {"none,none", "shuffle,none", "none,lz4", "shuffle,lz4", "none,bitpack", "none,zstd",
                "none,zstd:-5", "shuffle,zstd:9"});
  add_backends(result, counting_registry(default_backends(), counts), " (counted)",
               {"shuffle,lz4"});
  return result;
}

}  // namespace

TEST_CASE("Backend_EachOfItsPromises_IsKept", "[threads]") {
  const Subjects subjects = backends_under_test();
  for (const conformance::Promise& promise : conformance::promises())
    for (const conformance::Subject& subject : subjects) {
      if (!promise.concerns(subject.entry.traits)) continue;
      const NoWaiting no_waiting;
      const conformance::CheckLog log = conformance::check(promise, subject);
      INFO(subject.label << ", " << promise.name);
      for (const std::string& broken : log.broken()) FAIL_CHECK(broken);
      CHECK(log.held());
      CHECK(log.left_out().empty());
    }
}

TEST_CASE("BackendContext_BuiltInBackends_NeedNone") {
  for (const conformance::Subject& subject : backends_under_test()) {
    INFO(subject.label);
    conformance::LevelUnderTest level(subject);
    std::array<ContextBlock, kMostContextBlocks> blocks;
    CHECK(level.open().context(0, blocks) == 0);
  }
}

}  // namespace plait::test
