// The program opens stores from an untrusted source, and directories that are no stores.
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include <catch2/catch.hpp>
#include <cstdint>
#include <cstring>

#include "plait/mesh_io.h"
#include "support/test_meshes.h"
#include "tools/program.h"

namespace plait::test {
namespace {

namespace fs = std::filesystem;

void write_text(const fs::path& path, const std::string& text) { std::ofstream(path) << text; }

struct UntrustedWorkplace {
  UntrustedWorkplace() {
    write_ply(path("mesh.ply"), icosahedron());
    REQUIRE(run(here.path(), {"subdivide", "mesh.ply", "s.plait", "--levels", "2"}).status == 0);
  }
  fs::path path(const std::string& name) const { return here.path() / name; }

  TemporaryDirectory here;
};

/// All commands that open a store, for reading or writing.
std::vector<std::vector<std::string>> commands() {
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

/// A journal of one record with right checksums, which recovery would apply: docs/format.md,
/// "journal".
std::string forged_journal(const fs::path& store, const std::string& block) {
  const std::string manifest = content_of(store / "manifest");
  std::string header(48, '\0');
  std::uint64_t newest = 0, number = 1;
  for (const std::size_t slot : {0u, 4096u}) {
    std::uint64_t sequence = 0;
    std::memcpy(&sequence, &manifest[slot + 40], 8);
    if (manifest[slot + 1] == 'p' && sequence > newest) {
      newest = sequence;
      std::memcpy(&header[16], &manifest[slot + 24], 16);
    }
  }
  std::memcpy(header.data(), "plaitjnl", 8);
  header[8] = 1;
  std::memcpy(&header[32], &newest, 8);
  const std::uint64_t seed = XXH3_64bits(header.data(), 40);
  std::memcpy(&header[40], &seed, 8);
  std::string record(40, '\0');
  const std::uint32_t attribute = 7, level = 9;
  const std::uint64_t bytes = block.size();
  std::memcpy(&record[0], &attribute, 4);
  std::memcpy(&record[4], &level, 4);
  std::memcpy(&record[24], &bytes, 8);
  number = XXH3_64bits_withSeed((record.substr(0, 32) + block).data(), 32 + bytes, seed);
  std::memcpy(&record[32], &number, 8);
  return header + record + block;
}

}  // namespace

TEST_CASE("Program_LinkedLevelAndForgedHotJournal_LeaveTheVictimAlone") {
  for (const auto& command : commands()) {
    CAPTURE(command);
    const UntrustedWorkplace here;
    write_text(here.path("victim"), std::string(5000, 'v'));
    fs::create_symlink(here.path("victim"), here.path("s.plait/attribute7.level09.1"));
    write_text(here.path("s.plait/journal"),
               forged_journal(here.path("s.plait"), std::string(4096, 'x')));
    const Outcome outcome = run(here.here.path(), command);
    CHECK(outcome.status == 1);
    CHECK(outcome.error_lines() == 1);
    CHECK(outcome.errors.find("journal") != std::string::npos);
    CHECK(content_of(here.path("victim")) == std::string(5000, 'v'));
  }
}

TEST_CASE("Program_LockThatIsALink_LeavesTheVictimAlone") {
  for (const auto& command : commands()) {
    CAPTURE(command);
    const UntrustedWorkplace here;
    write_text(here.path("victim"), "mine");
    fs::remove(here.path("s.plait/lock"));
    fs::create_symlink(here.path("victim"), here.path("s.plait/lock"));
    const Outcome outcome = run(here.here.path(), command);
    // A reader needs no lock of the store.
    if (command.front() == "subdivide" ||
        command == std::vector<std::string>{"repair", "s.plait"}) {
      CHECK(outcome.status == 1);
      CHECK(outcome.errors.find("expected a regular file, found a symbolic link") !=
            std::string::npos);
    }
    CHECK(content_of(here.path("victim")) == "mine");
  }
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
      const Outcome outcome = run(here.here.path(), command);
      if (command[0] != "repair")
        CHECK(outcome.status != 0);  // a dry run succeeds if the file can be repaired
      CHECK((outcome.errors + outcome.output).find("a FIFO") != std::string::npos);
    }
    fs::remove(file);
    fs::rename(aside, file);
  }
  REQUIRE(::mkfifo(here.path("fifo.ply").c_str(), 0600) == 0);
  CHECK(run(here.here.path(), {"layout", "fifo.ply"}).status == 2);
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
    for (const auto& command : std::vector<std::vector<std::string>>{
             {"subdivide", "mesh.ply", name, "--levels", "1", "--force"},
             {"convert", "s.plait", name, "--backend", "pread", "--force"}}) {
      CAPTURE(command);
      const std::vector<std::string> before = names_in(here.here.path());
      CHECK(run(here.here.path(), command).status == 2);
      CHECK(names_in(here.here.path()) == before);
    }
  CHECK(names_in(here.path("mine")) == std::vector<std::string>{"lock", "manifest", "thesis.tex"});
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
      run(here.here.path(), {"subdivide", "mesh.ply", "s.plait", "--levels", "3", "--force"});
  CHECK(outcome.status == 0);
  CHECK(outcome.errors.find("thesis.tex") != std::string::npos);
  CHECK(content_of(here.path("s.plait/thesis.tex")) == "mine");
  CHECK(content_of(here.path("s.plait/figures/1.png")) == "mine too");
  CHECK(run(here.here.path(), {"verify", "s.plait"}).status == 0);
  CHECK(run(here.here.path(), {"info", "s.plait", "--json"}).json()["finest_level"] == 3);
  CHECK(names_in(here.here.path()) == std::vector<std::string>{"mesh.ply", "s.plait"});
}

TEST_CASE("LeftOvers_OfKilledRuns_AreRemovedByTheNextRunOfThatNameAndNoOther") {
  const UntrustedWorkplace here;
  const auto leave = [&](const std::string& name) {
    fs::create_directory(here.path(name));
    for (const char* file : {"manifest", "lock", "attribute0.level01.1", "image"})
      write_text(here.path(name) / file, "x");
    fs::create_directory(here.path(name) / "levels");
    write_text(here.path(name) / "levels" / "version.1", "x");
  };
  for (const char* name : {"s.plait.partial-11", "s.plait.repair-12", "t.plait.partial-13",
                           "s.plait.partial-14-2", "s.plait.partial-15", "s.plait.partial-x"})
    leave(name);
  write_text(here.path("s.plait.partial-15/notes"), "mine");
  write_text(here.path("out.ply.partial-16"), "x");
  write_text(here.path("out.ply.partial-17"), "x");
  leave("s.plait.partial-18");
  const int held = ::open(here.path("s.plait.partial-18").c_str(), O_RDONLY | O_DIRECTORY);
  REQUIRE(::flock(held, LOCK_SH) == 0);
  const int held_file = ::open(here.path("out.ply.partial-17").c_str(), O_RDONLY);
  REQUIRE(::flock(held_file, LOCK_EX) == 0);

  const auto there = [&](const std::string& name) { return fs::exists(here.path(name)); };
  const Outcome outcome =
      run(here.here.path(), {"subdivide", "mesh.ply", "s.plait", "--levels", "1", "--force"});
  CHECK(outcome.status == 0);
  CHECK(outcome.errors.find("s.plait.partial-11") != std::string::npos);
  for (const char* name : {"s.plait.partial-11", "s.plait.repair-12", "s.plait.partial-14-2"})
    CHECK_FALSE(there(name));
  for (const char* name :
       {"t.plait.partial-13", "s.plait.partial-15/notes", "s.plait.partial-18/levels/version.1",
        "s.plait.partial-x/lock", "out.ply.partial-16", "out.ply.partial-17"})
    CHECK(there(name));
  CHECK(run(here.here.path(), {"export", "s.plait", "out.ply"}).status == 0);
  CHECK_FALSE(there("out.ply.partial-16"));
  CHECK(there("out.ply.partial-17"));

  const std::vector<std::string> before = names_in(here.here.path());
  const Outcome listed = run(here.here.path(), {"clean", ".", "--dry-run", "--json"});
  CHECK(listed.status == 0);
  CHECK(listed.json()["count"] == 1);
  CHECK(listed.json()["left_over"].size() == 4);
  CHECK(names_in(here.here.path()) == before);
  CHECK(run(here.here.path(), {"clean", "."}).status == 0);
  CHECK_FALSE(there("t.plait.partial-13"));
  CHECK(there("s.plait.partial-15/notes"));
  CHECK(there("s.plait.partial-18/lock"));
  CHECK(there("out.ply.partial-17"));
  ::close(held);
  ::close(held_file);
  CHECK(run(here.here.path(), {"clean", "."}).status == 0);
  CHECK_FALSE(there("s.plait.partial-18"));
  CHECK_FALSE(there("out.ply.partial-17"));
}

}  // namespace plait::test
