// The main() of every test program: that of Catch, but a case without an assertion fails unless it
// was skipped.
#define CATCH_CONFIG_RUNNER
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdio>

#include "support/skip.h"

namespace {

constexpr int kSkipReturnCode = 77;  // as in tests/CMakeLists.txt

std::size_t skip_count = 0, assertion_count = 0;

class Totals final : public Catch::TestEventListenerBase {
 public:
  using TestEventListenerBase::TestEventListenerBase;
  void testRunEnded(const Catch::TestRunStats& run) override {
    assertion_count = run.totals.assertions.total();
  }
};
CATCH_REGISTER_LISTENER(Totals)

}  // namespace

void plait::test::skip(const std::string& reason) {
  std::printf("skipped: %s\n", reason.c_str());
  ++skip_count;
  SUCCEED("skipped");
}

int main(int count, char** arguments) {
  Catch::Session session;
  session.configData().warnings = Catch::WarnAbout::NoAssertions;
  const int outcome = session.run(count, arguments);
  return outcome == 0 && skip_count > 0 && skip_count == assertion_count ? kSkipReturnCode
                                                                         : outcome;
}
