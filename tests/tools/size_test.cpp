// A run that needs more memory or disk than the machine has is refused before it begins. The
// message has both figures.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "support/files_in_memory.h"
#include "support/resource_limit.h"
#include "support/skip.h"
#include "workplace.h"

namespace plait::test {
namespace {

constexpr std::uint64_t kMebibyte = 1 << 20;

struct SizeWorkplace : Workplace {
  SizeWorkplace() { succeed({"generate", "torus", "m.ply", "--vertices", "2000"}); }
};

void check_refusal(const SizeWorkplace& here, const Outcome& outcome, const std::string& code,
                   const std::string& option = "--ignore-size", const Words& names = {"m.ply"}) {
  CAPTURE(outcome.errors);
  CHECK(outcome.status == 1);
  REQUIRE(outcome.json()["error"]["code"] == code);
  const std::string message = outcome.json()["error"]["message"];
  const Words parts = code == "budget" ? Words{"needs", "found"} : Words{"expected", "found", "iB"};
  for (const std::string& part : parts) CHECK(message.find(part) != std::string::npos);
  CHECK(message.find(option) != std::string::npos);
  CHECK(here.names() == names);
}

}  // namespace

TEST_CASE("Size_BeyondTheMemory_IsRefusedBeforeAnythingIsMade") {
  const SizeWorkplace here;
  // 24 TiB of positions, and a base mesh of 10^9 faces.
  for (const Words& options : std::vector<Words>{{"--backend", "memory"},
                                                 {"--backend", "memory", "--max-slot", "1TiB"},
                                                 {"s.plait", "--backend", "pread"},
                                                 {"s.plait"}}) {
    Words arguments{"subdivide", "m.ply"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    arguments.insert(arguments.end(), {"--levels", "15", "--json"});
    check_refusal(here, here.plait(arguments), "out_of_memory");
  }
}

TEST_CASE("Size_BeyondWhatALimitOfMemoryLeaves_IsRefused") {
  if (!kAddressSpaceCanBeLimited) {
    skip("sanitizers need the address space");
    return;
  }
  const SizeWorkplace here;
  const Words arguments{"subdivide", "m.ply",    "--backend", "memory", "--levels",
                        "6",         "--memory", "16M",       "--json"};
  here.succeed(arguments);
  // 94 MiB of levels.
  Program limited(here.directory.path(), arguments, {}, 100 * kMebibyte);
  check_refusal(here, limited.wait(), "out_of_memory");
}

TEST_CASE("Size_BeyondTheDisk_IsRefusedBeforeAnythingIsMade") {
  const SizeWorkplace here;
  for (const std::string backend : {"pread", "compressed"})
    check_refusal(here,
                  here.plait({"subdivide", "m.ply", "s.plait", "--levels", "15", "--max-slot",
                              "1TiB", "--backend", backend, "--json"}),
                  "no_space");
}

TEST_CASE("Size_BeyondTheLongestFile_GoesOnWhereAskedAndEndsInAnError") {
  const SizeWorkplace here;
  const ResourceLimit limit(RLIMIT_FSIZE, kMebibyte);
  Words arguments{"subdivide", "m.ply", "s.plait", "--levels", "5", "--json"};
  check_refusal(here, here.plait(arguments), "no_space");
  arguments.push_back("--ignore-size");
  const Outcome outcome = here.plait(arguments);
  CHECK(outcome.status == 1);
  CHECK(outcome.errors.find("File too large") != std::string::npos);
  CHECK(here.names() == Words{"m.ply"});
}

TEST_CASE("Resume_BudgetTooSmallForTheLastLevel_IsRefusedBeforeTheFirst") {
  const SizeWorkplace here;
  Words arguments{"subdivide", "m.ply",  "s.plait",  "--levels", "6",
                  "--resume",  "--json", "--memory", "1M"};
  check_refusal(here, here.plait(arguments), "budget", "--memory");
  for (const std::string executor : {"sweep", "transparent"}) {
    Words with = arguments;
    with.insert(with.end(), {"--executor", executor, "--normals"});
    check_refusal(here, here.plait(with), "budget", "--memory");
  }
  // The same holds if the store already has coarser levels.
  here.succeed({"subdivide", "m.ply", "s.plait", "--levels", "2"});
  const Words both{"m.ply", "s.plait"};
  check_refusal(here, here.plait(arguments), "budget", "--memory", both);
  CHECK(here.report({"info", "s.plait"})["finest_level"] == 2);
  // No run can ignore it.
  arguments.push_back("--ignore-size");
  arguments[2] = "begun.plait";
  check_refusal(here, here.plait(arguments), "budget", "--memory", both);
}

TEST_CASE("Backend_NotGiven_IsChosenByTheSizeBesideTheMemory") {
  if (!kAddressSpaceCanBeLimited) {
    skip("sanitizers need the address space");
    return;
  }
  const SizeWorkplace here;
  const Words small{"subdivide", "m.ply", "small.plait", "--levels", "2", "--json"};
  const nlohmann::json chosen = here.plait(small).json();
  const bool is_in_memory = keeps_files_in_memory(here.directory.path());
  const std::string expected = is_in_memory ? "mmap" : "pread";
  CHECK(chosen["backend"] == expected);
  CHECK(chosen["backend_reason"].get<std::string>().find("small compared with the memory") !=
        std::string::npos);
  const nlohmann::json info = here.report({"info", "small.plait"});
  CHECK(info["auto_backend"] == expected);
  CHECK(info["auto_reason"].get<std::string>().find("small compared with the memory") !=
        std::string::npos);
  CHECK(here.plait({"info", "small.plait"}).output.find("auto       would choose " + expected) !=
        std::string::npos);
  const Words large{"subdivide", "m.ply", "large.plait", "--levels", "7",       "--json",
                    "--memory",  "16M",   "--threads",   "1",        "--digest"};
  Words overruled = large;
  overruled[2] = "overruled.plait";
  overruled.insert(overruled.end(), {"--backend", "pread"});
  // Half of the rest is less than the 376 MiB of the levels.
  const auto with_limit = [&](const Words& arguments) {
    const Outcome outcome = Program(here.directory.path(), arguments, {}, 600 * kMebibyte).wait();
    CAPTURE(arguments, outcome.errors);
    REQUIRE(outcome.status == 0);
    return outcome.json();
  };
  const nlohmann::json limited = with_limit(large), asked = with_limit(overruled),
                       copy = with_limit({"convert", "large.plait", "copy.plait", "--backend",
                                          "auto", "--memory", "16M", "--json"});
  CHECK(copy["backend"] == limited["backend"]);
  CHECK(copy["backend_reason"].get<std::string>().find("large compared with the memory") !=
        std::string::npos);
  CHECK(limited["backend_reason"].get<std::string>().find("large compared with the memory") !=
        std::string::npos);
  CHECK((limited["backend"] == "uring" || limited["backend"] == expected));
  CHECK(asked["backend"] == "pread");
  CHECK(asked["backend_reason"] == "given by the user");
  CHECK(asked["digest"] == limited["digest"]);
}

}  // namespace plait::test
