// What is made under a temporary name: whole or not there, whenever the process ends.
#include "plait/partial_output.h"

#include <sys/file.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <span>
#include <string>

#include "plait/error.h"
#include "plait/left_overs.h"
#include "support/before_operation.h"
#include "support/killing_operations.h"
#include "support/temporary_directory.h"

namespace plait::test {
namespace {

namespace fs = std::filesystem;

std::string content_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void make_file(const fs::path& path, const std::string& content, Existing existing) {
  PartialFile output(path, existing);
  output.file().write_at(0, std::as_bytes(std::span(content)));
  output.publish();
}

void remove_file_a(const Directory& directory) { directory.remove("a"); }

/// A directory that holds one file.
void make_directory(const fs::path& path) {
  PartialDirectory output(path, "partial", remove_file_a);
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
  const auto make = [&] { std::ofstream(here.path() / name) << "part"; };
  make();
  const std::vector<LeftOver> found = find_left_overs(directory);
  REQUIRE(found.size() == 1);
  const auto removed = [&](const auto& call) {
    make();
    const BeforeOperation other(FileOperation::Kind::kOpen, name,
                                [&] { fs::remove(here.path() / name); });
    call();
    CHECK(other.was_done());
  };
  removed([&] { CHECK(find_left_overs(directory).empty()); });
  removed([&] { CHECK(remove_left_over(directory, found[0])); });
}

TEST_CASE("PartialFile_KilledBeforeAnyOperation_LeavesTheOldFileOrTheNew") {
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

TEST_CASE("PartialDirectory_KilledBeforeAnyOperation_LeavesAWholeOneOrNone") {
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

TEST_CASE("PartialOutput_NotPublished_LeavesNothing") {
  const TemporaryDirectory here;
  {
    PartialFile file(here.path() / "f", Existing::kRefuse);
    PartialDirectory directory(here.path() / "d", "repair", remove_file_a);
    File(directory.directory(), "a", OpenMode::kCreate).close();
    CHECK(names_in(here.path()).size() == 2);
    for (const LeftOver& left_over : find_left_overs(Directory(here.path()))) {
      CHECK(left_over.in_use);
      CHECK_FALSE(remove_left_over(Directory(here.path()), left_over));
    }
  }
  CHECK(names_in(here.path()).empty());
}

TEST_CASE("PartialOutput_WhoseNameAnotherHas_LeavesTheOther") {
  const TemporaryDirectory here;
  const auto give_away = [&](const fs::path& made) {
    fs::rename(made, here.path() / "away");
    std::ofstream(made) << "another's";
  };
  {
    PartialFile file(here.path() / "f", Existing::kRefuse);
    give_away(file.path());
    CHECK_THROWS_AS(file.publish(), Error);
  }
  fs::remove(here.path() / "away");
  {
    PartialDirectory directory(here.path() / "d", "partial", remove_file_a);
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
  CHECK(others == 2);
}

TEST_CASE("PartialOutput_WhoseFinalNameIsTakenMeanwhile_IsRefused") {
  const TemporaryDirectory here;
  PartialFile file(here.path() / "f", Existing::kRefuse);
  PartialDirectory directory(here.path() / "d", "partial", remove_file_a);
  directory.directory();
  std::ofstream(here.path() / "f") << "first";
  fs::create_directory(here.path() / "d");
  CHECK_THROWS_AS(file.publish(), Error);
  CHECK_FALSE(directory.publish(true));
  CHECK(content_of(here.path() / "f") == "first");
  const fs::path kept = directory.keep_as("complete");
  CHECK(fs::is_directory(kept));
  CHECK(kept.filename().native().starts_with("d.complete-"));
}

}  // namespace plait::test
