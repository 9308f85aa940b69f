// The files of one export: they get their names together, or all stay where the error says.
#include "export/output_files.h"

#include <catch2/catch.hpp>
#include <cerrno>
#include <span>
#include <string>

#include "io/file_operations.h"
#include "plait/error.h"
#include "store/left_overs.h"
#include "support/answering_operations.h"
#include "support/error_of.h"
#include "support/file_bytes.h"
#include "support/temporary_directory.h"

namespace plait::test {
namespace {

namespace fs = std::filesystem;

/// Where the message says that `name` stays.
fs::path place_of(const std::string& message, const std::string& name) {
  const std::string said = name + " is complete and stays at ";
  const std::size_t at = message.find(said);
  REQUIRE(at != std::string::npos);
  const std::size_t begin = at + said.size();
  return message.substr(begin, message.find(';', begin) - begin);
}

}  // namespace

TEST_CASE("OutputFiles_OfWhichOneCannotGetItsName_AllStayAndTheErrorTellsWhere") {
  const TemporaryDirectory here;
  const fs::path path = here.path() / "m.gltf", beside = here.path() / "m.bin";
  for (const bool nothing_is_renamed : {false, true}) {
    CAPTURE(nothing_is_renamed);
    std::string message;
    {
      OutputFiles files(path, Existing::kReplace, {});
      files.main().write_at(0, std::as_bytes(std::span("text", 4)));
      files.add(".bin").write_at(0, std::as_bytes(std::span("numbers", 7)));
      const AnsweringOperations hook([&](const FileOperation& operation) {
        const bool is_it = operation.kind == FileOperation::Kind::kRename &&
                           (nothing_is_renamed || *operation.to == beside);
        return is_it ? EROFS : 0;
      });
      message = error_of([&] { files.publish(); }).what();
    }
    CHECK(content_of(place_of(message, "the new file")) == "numbers");
    CHECK(content_of(place_of(message, path.native())) == "text");
    CHECK(find_left_overs(Directory(here.path())).empty());
    CHECK_FALSE(fs::exists(path));
    CHECK_FALSE(fs::exists(beside));
  }
}

}  // namespace plait::test
