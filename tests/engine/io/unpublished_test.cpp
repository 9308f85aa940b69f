// What is made under a temporary name: whole or not there, whenever the process ends.
#include "io/unpublished.h"

#include <fmt/format.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cerrno>
#include <fstream>
#include <span>
#include <string>
#include <vector>

#include "io/file_operations.h"
#include "io/machine.h"
#include "io/made_mark.h"
#include "plait/error.h"
#include "store/left_overs.h"
#include "store/new_output.h"
#include "support/answering_operations.h"
#include "support/before_operation.h"
#include "support/error_of.h"
#include "support/file_bytes.h"
#include "support/killing_operations.h"
#include "support/temporary_directory.h"

namespace plait::test {
namespace {

namespace fs = std::filesystem;

void make_file(const fs::path& path, const std::string& content, Existing existing) {
  UnpublishedFile output(path, existing);
  output.file().write_at(0, std::as_bytes(std::span(content)));
  output.publish();
}

void remove_file_a(const Directory& directory) { directory.remove("a"); }

/// A directory that holds one file.
void make_directory(const fs::path& path) {
  UnpublishedDirectory output(path, "partial", MadeProof::kManifest, remove_file_a);
  File(output.directory(), "a", OpenMode::kCreate).close();
  REQUIRE(output.publish(true));
}

std::vector<std::string> names_in(const fs::path& directory) {
  return Directory(directory).names();
}

/// As `plait clean` does; what is left then.
std::vector<std::string> names_after_clean(const fs::path& path) {
  const Directory directory(path);
  for (const LeftOver& left_over : find_left_overs(directory)) {
    CHECK_FALSE(left_over.in_use);
    remove_left_over(directory, left_over);
  }
  return directory.names();
}

}  // namespace

TEST_CASE("LeftOver_RemovedByAnotherProcessMeanwhile_IsNoError") {
  const TemporaryDirectory here;
  const Directory directory(here.path());
  const std::string name = "mesh.ply.partial-12";
  const auto make = [&] {
    fs::remove_all(here.path() / name);
    fs::create_directory(here.path() / name);
    write_made_mark(Directory(here.path() / name));
    std::ofstream(here.path() / name / "output") << "part";
  };
  make();
  const std::vector<LeftOver> found = find_left_overs(directory);
  REQUIRE(found.size() == 1);
  const auto removed = [&](const auto& call) {
    make();
    const BeforeOperation other(FileOperation::Kind::kOpen, name,
                                [&] { fs::remove_all(here.path() / name); });
    call();
    CHECK(other.was_done());
  };
  removed([&] { CHECK(find_left_overs(directory).empty()); });
  removed([&] { CHECK(remove_left_over(directory, found[0])); });
}

TEST_CASE("LeftOver_WithoutAProofThatPlaitMadeIt_IsNone") {
  const TemporaryDirectory here;
  std::ofstream(here.path() / "essay.partial-77") << "mine";
  for (const char* file : {"manifest", "plait-made", "output", "lock", "image"}) {
    const fs::path directory = here.path() / (std::string(file) + ".partial-0012");
    fs::create_directory(directory);
    std::ofstream(directory / file) << "mine";
  }
  fs::create_directory(here.path() / "link.partial-3");
  std::ofstream(here.path() / "content");
  write_made_mark(Directory(here.path()));
  fs::create_symlink("../plait-made", here.path() / "link.partial-3" / "plait-made");
  const std::vector<std::string> before = names_in(here.path());
  CHECK(find_left_overs(Directory(here.path())).empty());
  for (const std::string& name : before)
    if (fs::is_directory(here.path() / name)) {
      LeftOver named;
      named.name = name;
      CHECK_FALSE(remove_left_over(Directory(here.path()), named));
      CHECK(names_in(here.path() / name).size() == 1);
    }
  CHECK(names_in(here.path()) == before);
}

TEST_CASE("UnpublishedFile_KilledBeforeAnyOperation_LeavesTheOldFileOrTheNew") {
  for (const bool replaces : {false, true}) {
    bool killed = true;
    std::uint64_t left_over = 0, operations = 0;
    for (; killed; ++operations) {
      const TemporaryDirectory here(Medium::kMemory);
      const fs::path path = here.path() / "f";
      if (replaces) make_file(path, "old", Existing::kRefuse);
      killed = run_and_kill_before(operations, [&] { make_file(path, "new", Existing::kReplace); });
      CAPTURE(replaces, operations);
      const std::string found = content_of(path);
      CHECK((found == "new" || (killed && found == (replaces ? "old" : ""))));
      left_over += names_in(here.path()).size() > (fs::exists(path) ? 1u : 0u);
      CHECK(names_after_clean(here.path()).size() == (fs::exists(path) ? 1u : 0u));
      if (!killed) CHECK(found == "new");
    }
    CHECK(operations > 6);  // create, lock, write, sync, rename, close, sync of the directory
    CHECK(left_over > 0);
  }
}

TEST_CASE("UnpublishedDirectory_KilledBeforeAnyOperation_LeavesAWholeOneOrNone") {
  bool killed = true;
  for (std::uint64_t operations = 0; killed; ++operations) {
    const TemporaryDirectory here(Medium::kMemory);
    const fs::path path = here.path() / "d";
    killed = run_and_kill_before(operations, [&] { make_directory(path); });
    CAPTURE(operations);
    CHECK((fs::exists(path / "a") || (killed && !fs::exists(path))));
    // The file in it is none that plait makes, and so it stays, and the directory with it.
    for (const std::string& name : names_after_clean(here.path()))
      CHECK((name == "d" || names_in(here.path() / name) == std::vector<std::string>{"a"}));
  }
}

TEST_CASE("UnpublishedOutput_NotPublished_LeavesNothing") {
  const TemporaryDirectory here;
  {
    UnpublishedFile file(here.path() / "f", Existing::kRefuse);
    file.file();
    UnpublishedDirectory directory(here.path() / "d", "repair", MadeProof::kMark, remove_file_a);
    File(directory.directory(), "a", OpenMode::kCreate).close();
    CHECK(names_in(here.path()).size() == 2);
    for (const LeftOver& left_over : find_left_overs(Directory(here.path()))) {
      CHECK(left_over.in_use);
      CHECK_FALSE(remove_left_over(Directory(here.path()), left_over));
    }
  }
  CHECK(names_in(here.path()).empty());
}

TEST_CASE("UnpublishedOutput_WhoseNameAnotherHas_LeavesTheOther") {
  const TemporaryDirectory here;
  fs::path kept;
  const auto give_away = [&](const fs::path& made) {
    fs::rename(made, here.path() / "away");
    std::ofstream(made) << "another's";
  };
  {
    UnpublishedFile file(here.path() / "f", Existing::kRefuse);
    file.file();
    give_away(file.path());
    CHECK_THROWS_AS(file.publish(), Error);
    kept = file.path();
  }
  CHECK(content_of(kept) == "another's");
  fs::remove_all(kept.parent_path());
  fs::remove(here.path() / "away");
  {
    UnpublishedDirectory directory(here.path() / "d", "partial", MadeProof::kManifest,
                                   remove_file_a);
    directory.directory();
    give_away(directory.name().path());
    CHECK_THROWS_AS(directory.publish(true), Error);
  }
  CHECK_FALSE(fs::exists(here.path() / "f"));
  CHECK_FALSE(fs::exists(here.path() / "d"));
  fs::remove_all(here.path() / "away");
  std::size_t others = 0;
  for (const std::string& name : names_in(here.path()))
    others += content_of(here.path() / name) == "another's";
  CHECK(others == 1);
}

TEST_CASE("UnpublishedOutput_WhoseLastSyncFails_SaysThatItIsCompleteUnderItsName") {
  class NoSyncOfNames final : public FileOperationHook {
   public:
    explicit NoSyncOfNames(fs::path directory) : directory_(std::move(directory)) {
      set_file_operation_hook(this);
    }
    ~NoSyncOfNames() { set_file_operation_hook(nullptr); }
    Verdict before(const FileOperation& operation) noexcept override {
      const bool is_it =
          operation.kind == FileOperation::Kind::kSyncDirectory && operation.path == directory_;
      return {.error = is_it ? EIO : 0};
    }
    void after(const FileOperation&) noexcept override {}

   private:
    fs::path directory_;
  };
  const TemporaryDirectory here;
  const NoSyncOfNames hook(here.path());
  const auto is_told = [&](const char* name, const Error& error) {
    CHECK(error.code() == ErrorCode::kIo);
    const std::string message = error.what();
    CHECK(message.starts_with((here.path() / name).native()));
    CHECK(message.find("it is complete and has its name") != std::string::npos);
    CHECK(fs::exists(here.path() / name));
  };
  is_told("f", error_of([&] { make_file(here.path() / "f", "new", Existing::kReplace); }));
  UnpublishedDirectory directory(here.path() / "d", "partial", MadeProof::kManifest, remove_file_a);
  directory.directory();
  is_told("d", error_of([&] { directory.publish(true); }));
}

TEST_CASE("UnpublishedOutput_WhoseFinalNameIsTakenMeanwhile_IsRefusedAndStaysBeside") {
  const TemporaryDirectory here;
  UnpublishedFile file(here.path() / "f", Existing::kRefuse);
  file.file().write_at(0, std::as_bytes(std::span("second", 6)));
  UnpublishedDirectory directory(here.path() / "d", "partial", MadeProof::kManifest, remove_file_a);
  directory.directory();
  std::ofstream(here.path() / "f") << "first";
  fs::create_directory(here.path() / "d");
  const Error error = error_of([&] { file.publish(); });
  CHECK(error.code() == ErrorCode::kInvalidArgument);
  const std::string message = error.what();
  const std::size_t at = message.find(" stays at ");
  REQUIRE(at != std::string::npos);
  const fs::path beside = message.substr(at + 10);
  CHECK(beside.filename().native().starts_with("f.complete-"));
  CHECK(content_of(beside) == "second");
  CHECK_FALSE(directory.publish(true));
  CHECK(content_of(here.path() / "f") == "first");
  const fs::path kept = directory.keep();
  CHECK(fs::is_directory(kept));
  CHECK(kept.filename().native().starts_with("d.complete-"));
}

TEST_CASE("BuildOutput_ErrorOfAnUnfinishedFile_IsAboutThePathThatTheUserGave") {
  const TemporaryDirectory here;
  UnpublishedFile file(here.path() / "f", Existing::kRefuse);
  file.file();
  const Error error = error_of([&] {
    build_output(file, [&] {
      throw Error(ErrorCode::kNoSpace, "write " + file.path().native() + ": full")
          .about(file.path(), 7);
    });
  });
  CHECK(error.code() == ErrorCode::kNoSpace);
  CHECK(error.what() == "write " + (here.path() / "f").native() + ": full");
  CHECK(error.path() == here.path() / "f");
  CHECK(error.offset() == 7);
}

// Some FUSE file systems refuse every renaming.
TEST_CASE("UnpublishedOutput_WhereNothingCanBeRenamed_StaysUnderItsUnfinishedName") {
  const TemporaryDirectory here;
  const auto place_in = [](const Error& error) {
    const std::string message = error.what();
    const std::size_t at = message.find(" is complete and stays at ");
    REQUIRE(at != std::string::npos);
    return fs::path(message.substr(at + 26));
  };
  const AnsweringOperations no_renaming(FileOperation::Kind::kRename, EROFS);
  const Error of_file = error_of([&] { make_file(here.path() / "f", "new", Existing::kReplace); });
  const Error of_directory = error_of([&] {
    make_new_directory(
        here.path() / "d", {}, [](const Directory& made) { made.remove("plan"); },
        [](const Directory& made) { File(made, "plan", OpenMode::kCreate).close(); });
  });
  CHECK(no_renaming.answers() >= 4);
  CHECK(of_file.code() == ErrorCode::kIo);
  const fs::path file = place_in(of_file), directory = place_in(of_directory);
  CHECK(directory.filename().native().starts_with("d.partial-"));
  for (const char* name : {"f", "d"}) remove_left_overs_of(here.path() / name, {});
  CHECK(names_after_clean(here.path()).size() == 2);
  CHECK(content_of(file) == "new");
  CHECK(names_in(directory) == std::vector<std::string>{"plan"});
}

TEST_CASE("UnfinishedName_OfThisMachine_SaysHostAndStartAndIsReadBack") {
  const TemporaryDirectory here;
  for (const char* kind : {"partial", "repair", "replaced"}) {
    UnfinishedName name(here.path() / "s.partial-3.plait", kind);
    const std::string first = name.next();
    const auto parts = read_unfinished_name(first);
    REQUIRE(parts);
    CHECK(parts->stem == "s.partial-3.plait");
    CHECK(parts->kind == kind);
    CHECK(parts->host == own_machine().host);
    CHECK(parts->start == own_machine().start);
    CHECK_FALSE(has_ended(parts->process));
    CHECK(name.next() != first);
  }
  for (const char* other : {"s.complete-h-1-2", "s.partial-x", "s.partial-x-y", ".partial-h-1-2",
                            "partial-h-1-2", "s.partial-h-1-", "s.part-h-1-2"})
    CHECK_FALSE(read_unfinished_name(other));
}

TEST_CASE("LeftOver_OfAnotherMachine_IsNotRemoved") {
  const TemporaryDirectory here;
  const OwnMachine& own = own_machine();
  const auto leave = [&](const std::string& machine) {
    const fs::path path = here.path() / ("f.partial-" + machine);
    fs::create_directory(path);
    write_made_mark(Directory(path));
    return path;
  };
  const fs::path own_one = leave(own.host + "-" + own.start + "-0123"),
                 of_other_host = leave("x" + own.host + "-" + own.start + "-0123");
  remove_left_overs_of(here.path() / "f", {});
  CHECK_FALSE(fs::exists(own_one));
  CHECK(fs::exists(of_other_host / kMadeMarkName));
  for (const LeftOver& left_over : find_left_overs(Directory(here.path()))) {
    CHECK(left_over.in_use);
    CHECK_FALSE(remove_left_over(Directory(here.path()), left_over));
  }
}

// The lock of a file system of a network may belong to one mount, or there is none: then only a
// process of this machine that has ended leaves something.
TEST_CASE("LeftOver_WhereNoLockTells_IsThatOfAProcessThatHasEnded") {
  struct NoLocks final : FileOperationHook {
    NoLocks() { set_file_operation_hook(this); }
    ~NoLocks() { set_file_operation_hook(nullptr); }
    Verdict before(const FileOperation& operation) noexcept override {
      if (operation.kind != FileOperation::Kind::kLock) return {};
      return {.error = ENOSYS};
    }
    void after(const FileOperation&) noexcept override {}
  };
  const TemporaryDirectory here;
  const pid_t child = ::fork();
  if (child == 0) ::_exit(0);
  REQUIRE(::waitpid(child, nullptr, 0) == child);
  const std::string own = new_maker_name();
  const std::string process(read_maker(own)->process);
  const std::string space = process.substr(0, process.find('.'));
  const std::string ended = fmt::format("{}.{:x}", space, child);
  CHECK(has_ended(ended));
  for (const std::string& other :
       {process, fmt::format("{}1.{:x}", space, child), fmt::format("{}.", space),
        fmt::format("{:x}", child), std::string(), std::string("."), std::string("x.y")})
    CHECK_FALSE(has_ended(other));

  const std::string machine = own_machine().host + "-" + own_machine().start + "-";
  const auto leave = [&](const std::string& maker) {
    const fs::path path = here.path() / ("f.partial-" + maker);
    fs::create_directory(path);
    write_made_mark(Directory(path));
    return path;
  };
  const fs::path left = leave(machine + ended + ".12");
  std::vector<fs::path> kept;
  for (const std::string& maker : {own, machine + "0123", own_machine().host + "-0-" + ended + ".1",
                                   "x" + machine + ended + ".1"})
    kept.push_back(leave(maker));
  const NoLocks no_locks;
  remove_left_overs_of(here.path() / "f", {});
  CHECK_FALSE(fs::exists(left));
  for (const fs::path& path : kept) CHECK(fs::exists(path / kMadeMarkName));
}

TEST_CASE("UnpublishedFile_WithTheLongestNameThatADirectoryTakes_IsMade") {
  const TemporaryDirectory here;
  for (const std::size_t bytes : {170u, 175u, 176u, 240u, 255u})
    for (const char* letter : {"n", "\xc3\xa9"}) {
      std::string name;
      while (name.size() + std::string(letter).size() <= bytes) name += letter;
      CAPTURE(bytes, letter);
      make_file(here.path() / name, "content", Existing::kRefuse);
      CHECK(content_of(here.path() / name) == "content");
      CHECK(run_and_kill_before(
          5, [&] { make_file(here.path() / name, "content", Existing::kReplace); }));
      CHECK(names_in(here.path()).size() == 2);
      remove_left_overs_of(here.path() / name, {});
      CHECK(names_in(here.path()).size() == 1);
      fs::remove(here.path() / name);
    }
}

}  // namespace plait::test
