// Random orders of public calls against a model of the bytes. By hand:
//   PLAIT_RANDOM_CALLS_SECONDS=3600 runs for an hour, from PLAIT_RANDOM_CALLS_SEED on (default: 1)
//   PLAIT_RANDOM_CALLS_SCRIPT="begin 2 0 1; sweep 0 3 1" runs one script
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdlib>
#include <string>

#include "acceptance/random_calls/script.h"
#include "support/sanitized.h"

using namespace plait::test;

namespace {

std::uint64_t number_of(const char* variable, std::uint64_t otherwise) {
  const char* const text = std::getenv(variable);
  return text != nullptr ? std::stoull(text) : otherwise;
}

}  // namespace

TEST_CASE("RandomCalls_OnAnyStore_GiveWhatTheModelSaysOrAnError") {
  if (const char* const text = std::getenv("PLAIT_RANDOM_CALLS_SCRIPT")) {
    const auto wrong = run_script(script_from(text));
    INFO(wrong.value_or("all right"));
    CHECK_FALSE(wrong);
    return;
  }
  const std::uint64_t first = number_of("PLAIT_RANDOM_CALLS_SEED", 1);
  const std::uint64_t seconds = number_of("PLAIT_RANDOM_CALLS_SECONDS", 0);
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(seconds);
  const std::uint64_t least = seconds > 0 ? 1 : unless_sanitized(400, 160);
  Outcomes outcomes;
  for (std::uint64_t seed = first; seed < first + least || std::chrono::steady_clock::now() < end;
       ++seed) {
    const Script script = random_script(seed);
    INFO("seed " << seed << ": " << to_text(script));  // of a crash, too
    if (const auto wrong = run_script(script, &outcomes)) {
      const Script shorter = shrunk(script);
      FAIL(*wrong << "\nPLAIT_RANDOM_CALLS_SCRIPT=\"" << to_text(shorter) << "\"\n"
                  << run_script(shorter).value_or("right when it runs again"));
    }
  }
  // The scripts do what they are for: every call succeeds often, and most are also refused.
  for (const auto& [name, counts] : outcomes.calls) {
    CAPTURE(name, counts.done, counts.refused);
    CHECK(counts.done + counts.refused > 0);
  }
  for (const char* name : {"add", "sweep", "visit", "writer", "subdivide", "commit", "roll_back",
                           "open", "view", "walk"}) {
    CAPTURE(name);
    CHECK(outcomes.of(name).done > unless_sanitized(10u, 1u));
  }
  for (const char* name : {"sweep", "visit", "subdivide", "commit", "close", "remove"}) {
    CAPTURE(name);
    CHECK(outcomes.of(name).refused > unless_sanitized(3u, 0u));
  }
}

TEST_CASE("RandomCalls_ScriptAsText_IsTheSameScript") {
  const Script script = random_script(7);
  CHECK(to_text(script_from(to_text(script))) == to_text(script));
}

TEST_CASE("RandomCalls_ScriptsThatFoundFaults_AreRight") {
  for (const char* const text : {
           "begin 553 626 494; subdivide 327 220 33",  // an attribute was added from a callback
           // A level stayed that no pass had filled, and was read as zeros.
           "begin 706 498 952; subdivide 23 307 646; subdivide 35 893 444",
           // The first one was cancelled when all positions were made.
           "begin 536 501 336; subdivide 278 568 556; subdivide 464 238 300",
           // A block was encoded from base records that the same pass changed afterwards.
           "begin 490 112 884; subdivide 121 685 187; commit 918 378 376; drop 252 296 761; "
           "open 39 384 671",
           "begin 484 748 138; subdivide 326 291 349; commit 576 7 916",
           // A writer filled the normals that a subdivision had left without their name.
           "begin 361 289 234; subdivide 8 862 901; writer 11 949 628; commit 0 0 0",
       }) {
    CAPTURE(text);
    const auto wrong = run_script(script_from(text));
    INFO(wrong.value_or("all right"));
    CHECK_FALSE(wrong);
  }
}
