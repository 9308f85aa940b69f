// The program opens stores from an untrusted source, and directories that are no stores.
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include <catch2/catch.hpp>
#include <cstdint>
#include <cstring>

#include "io/made_mark.h"
#include "plait/mesh_io.h"
#include "support/test_meshes.h"
#include "tools/program.h"

namespace plait::test {
namespace {

namespace fs = std::filesystem;

void write_text(const fs::path& path, const std::string& text) { std::ofstream(path) << text; }

struct UntrustedWorkplace : Workplace {
  UntrustedWorkplace() {
    write_ply(path("mesh.ply"), icosahedron());
    succeed({"subdivide", "mesh.ply", "s.plait", "--levels", "2"});
  }
};

/// All commands that open a store, for reading or writing.
std::vector<Words> commands() {
  return {{"info", "s.plait"},
          {"verify", "s.plait"},
          {"verify", "s.plait", "--fast"},
          {"digest", "s.plait"},
          {"export", "s.plait", "out.ply"},
          {"render", "s.plait", "out.png", "--size", "16x16"},
          {"convert", "s.plait", "copy.plait", "--backend", "pread"},
          {"repair", "s.plait"},
          {"repair", "s.plait", "--dry-run"},
          {"subdivide", "mesh.ply", "s.plait", "--levels", "3", "--resume"}};
}

}  // namespace

TEST_CASE("Program_LockThatIsAnotherFile_LeavesTheVictimAloneAndRepairMakesANewOne") {
  for (const bool hard : {false, true})
    for (const auto& command : commands()) {
      CAPTURE(hard, command);
      const UntrustedWorkplace here;
      write_text(here.path("victim"), "mine");
      const fs::path lock = here.path("s.plait/lock");
      fs::remove(lock);
      if (hard)
        fs::create_hard_link(here.path("victim"), lock);
      else
        fs::create_symlink(here.path("victim"), lock);
      const std::string words =
          hard ? "(hard links)" : "expected a regular file, found a symbolic link";
      const Outcome outcome = here.plait(command);
      // A reader needs no lock of the store.
      CHECK(outcome.status == (command.front() == "subdivide" ? 1 : 0));
      if (command.front() == "subdivide" || command.front() == "repair" ||
          command.front() == "verify")
        CHECK((outcome.errors + outcome.output).find(words) != std::string::npos);
      CHECK(content_of(here.path("victim")) == "mine");
      const bool repaired = command == Words{"repair", "s.plait"};
      CHECK(fs::is_symlink(lock) == (!hard && !repaired));
      CHECK(fs::hard_link_count(here.path("victim")) == (hard && !repaired ? 2 : 1));
      if (repaired) CHECK(here.plait(commands().back()).status == 0);
    }
}

TEST_CASE("Program_AStoreThatHasLostItsLock_GetsOneFromAnyWriter") {
  const UntrustedWorkplace here;
  const fs::path lock = here.path("s.plait/lock");
  const auto says = [&](const Words& command, const std::string& words) {
    const Outcome outcome = here.plait(command);
    CAPTURE(command, outcome.output, outcome.errors);
    CHECK(outcome.status == 0);
    CHECK(outcome.output.find(words) != std::string::npos);
  };
  fs::remove(lock);
  says({"verify", "s.plait"}, "lock: No such file");
  says({"repair", "s.plait", "--dry-run"}, "can be rebuilt: lock: ");
  CHECK_FALSE(fs::exists(lock));
  says({"repair", "s.plait"}, "rebuilt: lock: ");
  CHECK(fs::exists(lock));
  says({"repair", "s.plait"}, "nothing to repair");
  fs::remove(lock);
  CHECK(here.plait(commands().back()).status == 0);
  CHECK(fs::exists(lock));
  fs::remove(lock);
  says({"bounds", "s.plait"}, "");
  CHECK(fs::exists(lock));
}

TEST_CASE("Program_AFifoInPlaceOfAnyFile_EndsWithANamedErrorAtOnce") {
  const UntrustedWorkplace here;
  for (const std::string& name : names_in(here.path("s.plait"))) {
    const fs::path file = here.path("s.plait") / name, aside = here.path(name);
    fs::rename(file, aside);
    REQUIRE(::mkfifo(file.c_str(), 0600) == 0);
    for (const auto& command : commands()) {
      if (command[0] == "repair" && command.size() == 2) continue;  // restores the file
      // A reader needs no lock of the store.
      if (name == "lock" && command[0] != "subdivide") continue;
      CAPTURE(name, command);
      const Outcome outcome = here.plait(command);
      if (command[0] != "repair")
        CHECK(outcome.status != 0);  // a dry run succeeds if the file can be repaired
      CHECK((outcome.errors + outcome.output).find("a FIFO") != std::string::npos);
    }
    fs::remove(file);
    fs::rename(aside, file);
  }
  REQUIRE(::mkfifo(here.path("fifo.ply").c_str(), 0600) == 0);
  CHECK(here.plait({"layout", "fifo.ply"}).status == 2);
}

TEST_CASE("Force_OnADirectoryThatIsNoStore_IsRefusedAndChangesNothing") {
  const UntrustedWorkplace here;
  fs::create_directory(here.path("mine"));
  for (const char* name : {"manifest", "lock", "thesis.tex"})
    write_text(here.path("mine") / name, "mine");
  fs::create_directory(here.path("empty"));
  fs::create_directory(here.path("zeros"));
  write_text(here.path("zeros/manifest"), std::string(8192, '\0'));
  write_text(here.path("zeros/version.3"), "x");
  fs::create_directory_symlink(here.path("s.plait"), here.path("link"));
  for (const std::string name : {"mine", "empty", "zeros", "link"})
    for (const auto& command :
         std::vector<Words>{{"subdivide", "mesh.ply", name, "--levels", "1", "--force"},
                            {"convert", "s.plait", name, "--backend", "pread", "--force"}}) {
      CAPTURE(command);
      const Words before = here.names();
      CHECK(here.plait(command).status == 2);
      CHECK(here.names() == before);
    }
  CHECK(names_in(here.path("mine")) == Words{"lock", "manifest", "thesis.tex"});
  CHECK(content_of(here.path("mine/lock")) == "mine");
  CHECK(names_in(here.path("zeros")).size() == 2);
  CHECK(fs::is_symlink(here.path("link")));
}

TEST_CASE("Force_OnAStoreWithSomethingElseInIt_KeepsThatAndSaysSo") {
  const UntrustedWorkplace here;
  write_text(here.path("s.plait/thesis.tex"), "mine");
  fs::create_directory(here.path("s.plait/figures"));
  write_text(here.path("s.plait/figures/1.png"), "mine too");
  const Outcome outcome =
      here.plait({"subdivide", "mesh.ply", "s.plait", "--levels", "3", "--force"});
  CHECK(outcome.status == 0);
  CHECK(outcome.errors.find("thesis.tex") != std::string::npos);
  CHECK(content_of(here.path("s.plait/thesis.tex")) == "mine");
  CHECK(content_of(here.path("s.plait/figures/1.png")) == "mine too");
  CHECK(here.plait({"verify", "s.plait"}).status == 0);
  CHECK(here.plait({"info", "s.plait", "--json"}).json()["finest_level"] == 3);
  CHECK(here.names() == Words{"mesh.ply", "s.plait"});
}

TEST_CASE("LeftOvers_OfKilledRuns_AreRemovedByTheNextRunOfThatNameAndNoOther") {
  const UntrustedWorkplace here;
  const auto leave = [&](const std::string& name) {
    fs::create_directory(here.path(name));
    write_made_mark(Directory(here.path(name)));
    for (const char* file : {"lock", "attribute0.level01.1", "sealed", "output", "version.1"})
      write_text(here.path(name) / file, "x");
  };
  for (const char* name : {"s.plait.partial-11", "s.plait/scratch.repair-12", "t.plait.partial-13",
                           "s.plait.partial-14-2", "s.plait.partial-15", "s.plait.partial-x"})
    leave(name);
  write_text(here.path("s.plait.partial-15/notes"), "mine");
  leave("out.ply.partial-16");
  leave("out.ply.partial-17");
  // What a killed repair left inside a store disturbs no reader.
  fs::copy(here.path("s.plait"), here.path("u.plait"));
  leave("u.plait/scratch.repair-22");
  CHECK(here.plait({"verify", "u.plait"}).status == 0);
  CHECK(here.plait({"convert", "u.plait", "v.plait"}).status == 0);
  for (const auto& entry : fs::directory_iterator(here.path("v.plait")))
    CHECK(entry.is_regular_file());
  // A store says by its manifest whose it is.
  fs::copy(here.path("s.plait"), here.path("s.plait.partial-19"));
  write_text(here.path("s.plait.partial-20"), "mine");
  fs::create_directory(here.path("s.plait.partial-21"));
  write_text(here.path("s.plait.partial-21/manifest"), "mine");
  leave("s.plait.partial-18");
  const int held = ::open(here.path("s.plait.partial-18").c_str(), O_RDONLY | O_DIRECTORY);
  REQUIRE(::flock(held, LOCK_SH) == 0);
  const int held_file = ::open(here.path("out.ply.partial-17").c_str(), O_RDONLY | O_DIRECTORY);
  REQUIRE(::flock(held_file, LOCK_EX) == 0);

  const auto there = [&](const std::string& name) { return here.has(name); };
  const Outcome outcome =
      here.plait({"subdivide", "mesh.ply", "s.plait", "--levels", "1", "--force"});
  CHECK(outcome.status == 0);
  CHECK(outcome.errors.find("s.plait.partial-11") != std::string::npos);
  for (const char* name : {"s.plait.partial-11", "s.plait/scratch.repair-12",
                           "s.plait.partial-14-2", "s.plait.partial-19"})
    CHECK_FALSE(there(name));
  for (const char* name :
       {"t.plait.partial-13", "s.plait.partial-15/notes", "s.plait.partial-18/version.1",
        "s.plait.partial-x/lock", "s.plait.partial-20", "s.plait.partial-21/manifest",
        "out.ply.partial-16", "out.ply.partial-17"})
    CHECK(there(name));
  CHECK(here.plait({"export", "s.plait", "out.ply"}).status == 0);
  CHECK_FALSE(there("out.ply.partial-16"));
  CHECK(there("out.ply.partial-17"));

  const Words before = here.names();
  const Outcome listed = here.plait({"clean", ".", "--dry-run", "--json"});
  CHECK(listed.status == 0);
  // Control groups of the machine have paths. Tests that measure beside this one may leave some.
  Words removable, held_names;
  const auto report = listed.json();
  for (const auto& left_over : report["left_over"])
    if (const std::string name = left_over["name"]; !name.starts_with("/"))
      (left_over["in_use"] ? held_names : removable).push_back(name);
  CHECK(removable == Words{"t.plait.partial-13", "u.plait/scratch.repair-22"});
  CHECK(held_names == Words{"out.ply.partial-17", "s.plait.partial-18"});
  CHECK(here.names() == before);
  CHECK(here.plait({"clean", "."}).status == 0);
  CHECK_FALSE(there("t.plait.partial-13"));
  CHECK_FALSE(there("u.plait/scratch.repair-22"));
  CHECK(there("s.plait.partial-15/notes"));
  CHECK(there("s.plait.partial-18/lock"));
  CHECK(there("out.ply.partial-17"));
  ::close(held);
  ::close(held_file);
  CHECK(here.plait({"clean", "."}).status == 0);
  CHECK_FALSE(there("s.plait.partial-18"));
  CHECK_FALSE(there("out.ply.partial-17"));
  CHECK(content_of(here.path("s.plait.partial-20")) == "mine");
  CHECK(content_of(here.path("s.plait.partial-21/manifest")) == "mine");
}

}  // namespace plait::test
