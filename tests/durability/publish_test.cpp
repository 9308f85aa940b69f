// The power fails at every operation of an output that is made under a temporary name.
#include <algorithm>
#include <catch2/catch.hpp>
#include <span>
#include <string>

#include "durability/power_cut.h"
#include "io/unpublished.h"
#include "support/temporary_directory.h"

namespace plait::test {
namespace {

namespace fs = std::filesystem;

constexpr int kOutcomesPerOperation = 40;
/// Several of the pieces that the disk writes at once.
const std::string kOld(3000, 'o'), kNew(5000, 'n');

void write_file(File& file, const std::string& content) {
  file.write_at(0, std::as_bytes(std::span(content)));
}

void publish_file(const fs::path& path, const std::string& content) {
  UnpublishedFile output(path, Existing::kReplace);
  write_file(output.file(), content);
  output.publish();
}

/// An operation that changes something: the power fails before it, too.
void go_on(const fs::path& directory) { File(directory / "later", OpenMode::kCreate).close(); }

std::string published_content_of(const PowerCut::Outcome& outcome, const fs::path& file) {
  const auto found = outcome.files.find(file);
  if (found == outcome.files.end()) return "nothing";
  std::string content;
  for (const std::byte byte : *found->second) content += static_cast<char>(byte);
  return content;
}

/// A directory that holds one file, all on the disk but the name of the directory.
class OneFile {
 public:
  explicit OneFile(const fs::path& path)
      : output_(path, "partial", MadeProof::kManifest,
                [](const Directory& made) { made.remove("a"); }) {
    File file(output_.directory(), "a", OpenMode::kCreate);
    write_file(file, kNew);
    file.sync();
    file.close();
  }
  UnpublishedDirectory& output() { return output_; }

 private:
  UnpublishedDirectory output_;
};

/// What the disk may hold while `make` works (note 0) and when it has returned (note 1).
template <class Make>
std::vector<PowerCut::Outcome> outcomes_of(const fs::path& root, Make make) {
  std::uint64_t made = 0;
  PowerCut cut(root, 1, kOutcomesPerOperation, [&] { return made; });
  make();
  made = 1;
  go_on(root);
  REQUIRE(std::ranges::any_of(cut.outcomes(), [](const auto& outcome) { return outcome.note; }));
  return cut.outcomes();
}

}  // namespace

TEST_CASE("PowerCut_WhileAFileIsPublished_LeavesTheOldOneWholeOrTheNewOne") {
  for (const bool replaces : {false, true}) {
    const TemporaryDirectory here(Medium::kMemory);
    if (replaces) publish_file(here.path() / "f", kOld);
    const auto found = outcomes_of(here.path(), [&] { publish_file(here.path() / "f", kNew); });
    for (const PowerCut::Outcome& outcome : found) {
      CAPTURE(replaces, outcome.operation, outcome.note);
      const std::string content = published_content_of(outcome, "f");
      const bool is_old = content == (replaces ? kOld : "nothing");
      CHECK((content == kNew || (outcome.note == 0 && is_old)));
    }
  }
}

TEST_CASE("PowerCut_WhileADirectoryIsPublished_LeavesItWholeOrNotThere") {
  for (const bool keeps : {false, true}) {
    const TemporaryDirectory here(Medium::kMemory);
    fs::path path = here.path() / "d";
    const auto found = outcomes_of(here.path(), [&] {
      OneFile made(path);
      if (keeps)
        path = made.output().keep();
      else
        REQUIRE(made.output().publish(true));
    });
    for (const PowerCut::Outcome& outcome : found) {
      CAPTURE(keeps, outcome.operation, outcome.note);
      const fs::path name = path.filename();
      if (outcome.note == 1) CHECK(outcome.directories.contains(name));
      if (outcome.directories.contains(name) && !keeps)
        CHECK(published_content_of(outcome, name / "a") == kNew);
    }
  }
}

}  // namespace plait::test
