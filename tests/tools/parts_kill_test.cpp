// Kills `plait part` and `plait join` at random instants. The same command again must end with the
// store of one undisturbed run, and nothing half-made may have a final name.
//
// With PLAIT_LONG=1 in the environment the test kills more than a thousand times.
#include <signal.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "support/computing.h"
#include "support/sanitized.h"
#include "workplace.h"

namespace plait::test {
namespace {

int rounds() { return std::getenv("PLAIT_LONG") ? 100 : unless_sanitized(3, 1); }

/// Runs the command and kills it again and again, later each time, until it ends. Returns how often
/// it was killed.
int run_until_done(const std::filesystem::path& directory, const Words& arguments,
                   std::mt19937_64& random, std::uint64_t longest_us) {
  for (int kills = 0;; ++kills, longest_us += longest_us / 4) {
    Program program(directory, arguments);
    computes_for(program.process(), std::chrono::microseconds(random() % longest_us));
    ::kill(program.process(), SIGKILL);
    const Outcome outcome = program.wait();
    if (outcome.status == 1000 + SIGKILL) continue;
    CAPTURE(arguments, outcome.errors);
    REQUIRE(outcome.status == 0);
    return kills;
  }
}

}  // namespace

TEST_CASE("PartAndJoin_KilledAgainAndAgain_ArriveAtTheStoreOfOneRun") {
  std::mt19937_64 random(13);
  const Workplace here(Medium::kMemory);
  here.succeed({"generate", "torus", "m.ply", "--vertices", "500"});
  const Outcome whole = here.succeed(
      {"subdivide", "m.ply", "whole.plait", "--levels", "4", "--normals", "--digest", "--json"});
  int kills = 0;
  for (int round = 0; round < rounds(); ++round) {
    here.succeed({"plan", "m.ply", "p", "--levels", "4", "--normals", "--parts", "3"});
    for (const char* const part : {"0", "1", "2"})
      kills += run_until_done(here.directory.path(), {"part", "p", part}, random, 20000);
    // A killed join may have made the store already.
    kills +=
        run_until_done(here.directory.path(), {"join", "p", "s.plait", "--force"}, random, 10000);
    const Outcome digest = here.succeed({"digest", "s.plait", "--json"});
    CHECK(digest.json()["digest"] == whole.json()["digest"]);
    // What was killed left nothing but the plan, and the last join has removed that of earlier
    // ones.
    for (const auto& entry : std::filesystem::directory_iterator(here.directory.path())) {
      CAPTURE(entry.path());
      CHECK(entry.path().native().find("partial") == std::string::npos);
    }
    int directories = 0;
    for (const auto& entry : std::filesystem::directory_iterator(here.path("p")))
      directories += entry.is_directory() ? 1 : 0;
    CHECK(directories == 3);
    std::filesystem::remove_all(here.path("p"));
    std::filesystem::remove_all(here.path("s.plait"));
  }
  CHECK(kills > 0);
}

TEST_CASE("PassPartAndJoin_KilledAgainAndAgain_ArriveAtTheVersionOfOneRun") {
  std::mt19937_64 random(17);
  const Workplace here(Medium::kMemory);
  const auto succeed = [&](const Words& arguments) { return here.succeed(arguments); };
  const auto make_shards = [&](const char* store) {
    succeed({"plan", "m.ply", "p", "--levels", "4", "--parts", "3"});
    for (const char* const part : {"0", "1", "2"}) succeed({"part", "p", part});
    succeed({"join", "p", store});
    std::filesystem::remove_all(here.path("p"));
  };
  const auto digest_of = [&](const char* store) {
    return succeed({"digest", store, "--json"}).json()["digest"];
  };
  succeed({"generate", "torus", "m.ply", "--vertices", "500"});
  make_shards("undisturbed.plait");
  succeed({"plan", "--pass", "smooth", "undisturbed.plait", "q"});
  for (const char* const part : {"0", "1", "2"}) succeed({"part", "q", part});
  succeed({"join", "q", "undisturbed.plait"});
  std::filesystem::remove_all(here.path("q"));
  const auto expected = digest_of("undisturbed.plait");
  int kills = 0;
  for (int round = 0; round < rounds(); ++round) {
    make_shards("s.plait");
    succeed({"plan", "--pass", "smooth", "s.plait", "q"});
    for (const char* const part : {"0", "1", "2"})
      kills += run_until_done(here.directory.path(), {"part", "q", part}, random, 15000);
    // A killed join may have committed the version already.
    kills += run_until_done(here.directory.path(), {"join", "q", "s.plait"}, random, 8000);
    CHECK(succeed({"join", "q", "s.plait", "--json"}).json()["version"] == 2);
    CHECK(digest_of("s.plait") == expected);
    succeed({"verify", "s.plait"});
    int directories = 0;
    for (const auto& entry : std::filesystem::directory_iterator(here.path("q")))
      directories += entry.is_directory() ? 1 : 0;
    CHECK(directories == 3);
    std::filesystem::remove_all(here.path("q"));
    std::filesystem::remove_all(here.path("s.plait"));
  }
  CHECK(kills > 0);
}

TEST_CASE("PassOnTheCommandLine_OptionsAndRefusals_AreSaid") {
  const Workplace here(Medium::kMemory);
  const auto status = [&](const Words& arguments) { return here.plait(arguments).status; };
  REQUIRE(status({"generate", "torus", "m.ply", "--vertices", "500"}) == 0);
  CHECK(status({"plan", "m.ply", "p", "--levels", "3"}) == 2);  // --parts is missing
  CHECK(status({"plan", "m.ply", "p", "--levels", "3", "--parts", "2", "--factor", "0.1"}) == 2);
  REQUIRE(status({"plan", "m.ply", "p", "--levels", "3", "--parts", "4"}) == 0);
  for (const char* const part : {"0", "1", "2", "3"}) REQUIRE(status({"part", "p", part}) == 0);
  REQUIRE(status({"join", "p", "s.plait"}) == 0);
  const Words noise = {"plan", "--pass",      "noise", "s.plait",  "q",       "--seed",
                       "3",    "--amplitude", "0.001", "--sbatch", "array.sh"};
  Words with_parts = noise;
  with_parts.insert(with_parts.end(), {"--parts", "3"});
  CHECK(status(with_parts) == 2);
  CHECK(status({"plan", "--pass", "polish", "s.plait", "q"}) == 2);
  CHECK_FALSE(here.has("q"));
  CHECK_FALSE(here.has("array.sh"));
  Words with_json = noise;
  with_json.push_back("--json");
  const Outcome planned = here.succeed(with_json);
  CHECK(planned.json()["pass"] == "noise");
  CHECK(planned.json()["version"] == 1);
  CHECK(planned.json()["attribute"] == "position");
  CHECK(planned.json()["parts"].size() == 4);
  CHECK(planned.json()["diagonal"] > 0);
  CHECK(content_of(here.path("array.sh")).find("--array=0-3") != std::string::npos);
  CHECK(status({"part", "p", "2", "--again", "--store", "s.plait"}) == 2);  // it reads no store
  REQUIRE(status({"part", "q", "2", "--store", "s.plait"}) == 0);
  const Outcome incomplete = here.plait({"join", "q", "s.plait"});
  CHECK(incomplete.status == 4);
  CHECK(incomplete.last_line() == "0-1,3");
  for (const char* const part : {"0", "1", "3"}) REQUIRE(status({"part", "q", part}) == 0);
  CHECK(status({"join", "q", "s.plait", "--concat"}) == 2);
  REQUIRE(status({"join", "q", "s.plait", "--verify"}) == 0);
  // What plait displace makes of a store in one piece.
  REQUIRE(status({"subdivide", "m.ply", "w.plait", "--levels", "3"}) == 0);
  REQUIRE(status({"displace", "w.plait", "d.plait", "--seed", "3", "--amplitude", "0.001"}) == 0);
  CHECK(here.plait({"digest", "s.plait"}).last_line() ==
        here.plait({"digest", "d.plait"}).last_line());
  CHECK(status({"plan", "--pass", "smooth", "w.plait", "r"}) != 0);  // in one piece
  const Outcome moved = here.plait({"part", "q", "0", "--again"});
  CHECK(moved.status != 0);
  CHECK(moved.errors.find("found version 2") != std::string::npos);
}

TEST_CASE("PlanPartJoin_OnTheCommandLine_SayWhatIsMissing") {
  const Workplace here(Medium::kMemory);
  here.succeed({"generate", "torus", "m.ply", "--vertices", "500"});
  const Outcome planned = here.succeed({"plan", "m.ply", "p", "--levels", "3", "--parts", "5",
                                        "--sbatch", "array.sh", "--array", "2", "--json"});
  CHECK(planned.json()["parts"].size() == 5);
  CHECK(content_of(here.path("array.sh")).find("--array=0-0 array.sh --offset 4") !=
        std::string::npos);
  CHECK(here.plait({"plan", "m.ply", "p", "--levels", "3", "--parts", "5"}).status == 2);
  // Part 3 as the second task of an array with an offset.
  here.succeed({"part", "p", "1", "--offset", "2"});
  const Outcome incomplete = here.plait({"join", "p", "s.plait"});
  CHECK(incomplete.status == 4);
  CHECK(incomplete.last_line() == "0-2,4");
  CHECK_FALSE(here.has("s.plait"));
  CHECK(here.plait({"part", "p", "5"}).status == 2);
  for (const char* const part : {"0", "1", "2", "4"}) here.succeed({"part", "p", part});
  CHECK(here.plait({"part", "p", "4"}).output.find("done already") != std::string::npos);
  here.succeed({"join", "p", "s.plait"});
  const Outcome again = here.plait({"join", "p", "s.plait"});
  CHECK(again.status == 0);
  CHECK(again.output.find("was joined before") != std::string::npos);
  CHECK(here.plait({"join", "p", "s.plait", "--force", "--concat"}).status == 0);
  const Words reading[] = {{"verify", "s.plait"},
                           {"info", "s.plait"},
                           {"bounds", "s.plait"},
                           {"export", "s.plait", "s.ply", "--level", "2"},
                           {"convert", "s.plait", "c.plait", "--compress", "default", "--verify"}};
  here.succeed({"join", "p", "s.plait", "--force"});
  for (const Words& arguments : reading) {
    here.succeed(arguments);
  }
  const Outcome repaired = here.plait({"repair", "s.plait"});
  CAPTURE(repaired.output, repaired.errors);
  CHECK(repaired.status == 0);
  CHECK(repaired.output.find("nothing to repair") != std::string::npos);
  // A bit of a block of shard 1: the rest of the store is as it was.
  flip_byte(here.path("s.plait/attribute0.levels.1.shard1"), 20);
  const Outcome lost = here.plait({"repair", "s.plait"});
  CHECK(lost.status == 1);
  CHECK(lost.output.find("plait part --again") != std::string::npos);
  here.succeed({"plan", "--of", "s.plait", "again"});
  CHECK(here.plait({"plan", "--of", "s.plait", "more", "--parts", "2"}).status == 2);
  here.succeed({"part", "again", "1"});
  const Outcome mended = here.plait({"join", "again", "s.plait"});
  CHECK(mended.status == 0);
  CHECK(mended.errors.find("shard 1") != std::string::npos);
  CHECK(here.plait({"verify", "s.plait"}).status == 0);
}

TEST_CASE("StatusAndLists_OfAPlan_SayWhatIsLeft") {
  const Workplace here(Medium::kMemory);
  here.succeed({"generate", "torus", "m.ply", "--vertices", "500"});
  here.succeed({"plan", "m.ply", "p", "--levels", "3", "--parts", "5", "--sbatch", "array.sh"});
  const auto status = [&] { return here.plait({"status", "p", "--json"}).json(); };
  CHECK(status()["waiting"] == 5);
  CHECK(status()["array"] == "0-4");
  CHECK_FALSE(status().contains("seconds_left"));
  for (const char* const part : {"1", "3"}) here.succeed({"part", "p", part, "--threads", "1"});
  // What a part of another machine looks like, whether it runs or not.
  std::filesystem::create_directory(here.path("p/part.4-elsewhere-01234567-1.2.3"));
  const auto now = status();
  CHECK(now["done"] == 2);
  CHECK(now["running"] == 1);
  CHECK(now["array"] == "0,2");
  CHECK(now["seconds_left"] > 0);
  REQUIRE(now["parts"].size() == 3);
  CHECK(now["parts"][0]["state"] == "done");
  CHECK(now["parts"][0]["user"] != "");
  CHECK(now["parts"][0]["peak_memory_bytes"] > 1'000'000);
  CHECK(now["parts"][2]["host"] == "elsewhere");
  CHECK(here.plait({"status", "p"}).output.find("2 of 5 parts done") != std::string::npos);
  CHECK(here.plait({"status", "none"}).status == 2);

  const Outcome lost = here.plait({"join", "p", "s.plait", "--missing-to", "lost"});
  CHECK(lost.status == 4);
  CHECK(lost.last_line() == "0,2,4");
  CHECK(content_of(here.path("lost")) == "0\n2\n4\n");
  for (const char* const line : {"0", "1", "2"})
    here.succeed({"part", "p", line, "--list", "lost"});
  CHECK(here.plait({"part", "p", "3", "--list", "lost"}).status == 2);
  here.succeed({"join", "p", "s.plait", "--missing-to", "lost"});
  CHECK(content_of(here.path("lost")).empty());
  const std::string script = content_of(here.path("array.sh"));
  for (const char* const line : {"#SBATCH --mem=", "#SBATCH --time=", "#SBATCH --cpus-per-task=1",
                                 "#SBATCH --output=", "--memory 268435456"})
    CHECK(script.find(line) != std::string::npos);
}

TEST_CASE("Chain_OfAPlan_JoinsWhatEndsAndGivesLostPartsOnceMore") {
  const Workplace here(Medium::kMemory);
  const std::filesystem::path& at = here.directory.path();
  std::filesystem::create_directory(at / "bin");
  std::filesystem::create_symlink(PLAIT_PROGRAM, at / "bin/plait");
  // A Slurm that runs each job at once, and loses the task whose number is in the file "loses".
  std::ofstream(at / "bin/sbatch") << R"sh(#!/bin/sh
echo "$*" >>"$HOME/submitted"
last=
while :; do
  case $1 in
    --array=0-*) last=${1#--array=0-} ;;
    --*) ;;
    *) break ;;
  esac
  shift
done
if [ -n "$last" ]; then
  for task in $(seq 0 "$last"); do
    [ "$task" = "$(cat "$HOME/loses")" ] || SLURM_ARRAY_TASK_ID=$task sh "$@" >&2
  done
else
  sh "$@" >&2
fi
wc -l <"$HOME/submitted"
)sh";
  std::filesystem::permissions(at / "bin/sbatch", std::filesystem::perms::owner_all);
  const auto shell = [&](const std::string& words) {
    return std::system(("cd '" + at.native() + "' && HOME=\"$PWD\" PATH=\"$PWD/bin:$PATH\" " +
                        words + " >out 2>errors")
                           .c_str());
  };
  here.succeed({"generate", "torus", "m.ply", "--vertices", "500"});
  const Words plan = {"plan",    "m.ply", "it's a plan", "--levels", "3",       "--parts", "5",
                      "--array", "3",     "--sbatch",    "a b.sh",   "--chain", "chain.sh"};
  here.succeed(plan);
  std::ofstream(at / "loses") << "none\n";
  CHECK(shell("sh chain.sh") != 0);
  CHECK_FALSE(std::filesystem::exists(at / "submitted"));

  SECTION("all parts end, and a pass follows") {
    REQUIRE(shell("sh chain.sh s.plait 'plait plan --pass normals s.plait p2 --sbatch n.sh --chain "
                  "c2.sh && sh c2.sh s.plait'") == 0);
    CHECK(here.plait({"verify", "s.plait"}).status == 0);
    CHECK(here.plait({"info", "s.plait", "--json"}).output.find("\"normal\"") != std::string::npos);
    const std::string submitted = content_of(at / "submitted");
    CHECK(std::count(submitted.begin(), submitted.end(), '\n') == 5);
    CHECK(submitted.find("--offset 3") != std::string::npos);
    CHECK_FALSE(std::filesystem::exists(at / "s.plait.lost"));
  }
  SECTION("a task is lost the first time") {
    // Of each array of three or two tasks one is lost, and none of the array of one task.
    std::ofstream(at / "loses") << "1\n";
    REQUIRE(shell("sh chain.sh s.plait 'echo then >then'") == 0);
    CHECK_FALSE(std::filesystem::exists(at / "then"));  // of two lost parts one is lost again
    CHECK_FALSE(std::filesystem::exists(at / "s.plait"));
    std::ofstream(at / "loses") << "none\n";
    REQUIRE(shell("sh chain.sh s.plait 'echo then >then'") == 0);
    CHECK(std::filesystem::exists(at / "then"));
    CHECK(here.plait({"verify", "s.plait"}).status == 0);
  }
  SECTION("the lost part comes with the second array") {
    std::ofstream(at / "loses") << "2\n";
    REQUIRE(shell("sh chain.sh s.plait 'echo then >then'") == 0);
    CHECK(std::filesystem::exists(at / "then"));
    CHECK(here.plait({"verify", "s.plait"}).status == 0);
    CHECK(content_of(at / "submitted").find("--list") != std::string::npos);
  }
  SECTION("no chain without an array, and none over another file") {
    CHECK(here.plait({"plan", "m.ply", "p2", "--levels", "3", "--parts", "5", "--chain", "c"})
              .status == 2);
    CHECK(here.plait({"plan", "m.ply", "p2", "--levels", "3", "--parts", "5", "--sbatch", "new.sh",
                      "--chain", "/proc/c.sh"})
              .status == 2);
    CHECK_FALSE(std::filesystem::exists(at / "p2"));
    CHECK_FALSE(std::filesystem::exists(at / "new.sh"));
  }
}

TEST_CASE("ExitStatus_OfPartAndJoin_TellsWhetherToTryAgain") {
  const Workplace here(Medium::kMemory);
  const std::filesystem::path& at = here.directory.path();
  here.succeed({"generate", "torus", "m.ply", "--vertices", "500"});
  here.succeed({"plan", "m.ply", "p", "--levels", "3", "--parts", "2"});
  // Never: no such plan, no such part.
  CHECK(here.plait({"part", "none", "0"}).status == 2);
  CHECK(here.plait({"part", "p", "2"}).status == 2);
  CHECK(here.plait({"join", "none", "s.plait"}).status == 2);
  // A file that another machine has made may come to be seen.
  std::filesystem::rename(at / "p/base.mesh", at / "kept");
  const Outcome unseen = here.plait({"part", "p", "0", "--json"});
  CHECK(unseen.status == 3);
  CHECK(unseen.json()["error"]["code"] == "not_found");
  std::filesystem::rename(at / "kept", at / "p/base.mesh");
  // A disk that takes no more; without the trap, a signal would end the process.
  const std::string full = "cd '" + at.native() + "' && trap '' XFSZ && ulimit -f 8 && '" +
                           PLAIT_PROGRAM + "' part p 0 --threads 1 2>errors";
  const int status = std::system(full.c_str());
  REQUIRE(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 3);
  CHECK(content_of(at / "errors").find("p/part.0-") != std::string::npos);
  // And with room, it ends well.
  for (const char* const part : {"0", "1"})
    CHECK(here.plait({"part", "p", part, "--threads", "1"}).status == 0);
  CHECK(here.plait({"join", "p", "s.plait"}).status == 0);
  // A budget that is too small stays so.
  CHECK(here.plait({"part", "p", "0", "--again", "--memory", "1K", "--threads", "1"}).status == 1);
}

TEST_CASE("Plan_ScriptThatCannotBeWritten_LeavesNoPlan") {
  const Workplace here(Medium::kMemory);
  here.succeed({"generate", "torus", "m.ply", "--vertices", "500"});
  std::ofstream(here.path("taken.sh")) << "#!/bin/sh\n";
  // That /proc takes no files shows only when one is made.
  for (const char* const script : {"taken.sh", "nowhere/array.sh", "/proc/array.sh"}) {
    CAPTURE(script);
    CHECK(here.plait({"plan", "m.ply", "p", "--levels", "3", "--parts", "5", "--sbatch", script})
              .status == 2);
    CHECK(here.names() == Words{"m.ply", "taken.sh"});
  }
}

TEST_CASE("Plan_Calibrated_NamesTheRates") {
  const Workplace here(Medium::kMemory);
  here.succeed({"generate", "torus", "m.ply", "--vertices", "500"});
  const Words plan = {"plan", "m.ply", "p", "--levels", "3", "--parts", "5", "--calibrate"};
  const Outcome outcome = here.succeed(plan);
  CHECK(outcome.output.find("M points/s") != std::string::npos);
  CHECK(outcome.output.find("written and synced") != std::string::npos);
  CHECK(here.names() == Words{"m.ply", "p"});
  std::filesystem::remove_all(here.path("p"));
  Words with_json = plan;
  with_json.push_back("--json");
  const auto report = here.plait(with_json).json();
  CHECK(report["rates"]["points_per_second"] > 0);
  CHECK(report["rates"]["bytes_per_second"] > 0);
  CHECK(report["parts"][4]["seconds"] > 0);
}

}  // namespace plait::test
