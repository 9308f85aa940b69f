#include "plait/error.h"

#include <catch2/catch.hpp>
#include <cerrno>
#include <limits>
#include <vector>

#include "plait/base_mesh.h"
#include "plait/extend/file.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"

namespace plait::test {

TEST_CASE("Error_AboutAFile_HasItsPathAndOffsetAndCopiesShareThem") {
  const Error plain(ErrorCode::kIo, "text");
  CHECK(plain.path().empty());
  CHECK_FALSE(plain.offset().has_value());
  const Error about = plain.about("/x/y", 17);
  CHECK(about.path() == "/x/y");
  CHECK(about.offset() == 17);
  CHECK(about.code() == ErrorCode::kIo);
  CHECK(std::string(about.what()) == "text");
  const Error reworded(about, "other words");
  CHECK(std::string(reworded.what()) == "other words");
  CHECK(reworded.path() == "/x/y");
  CHECK(reworded.offset() == 17);
  CHECK(plain.about("z").offset() == std::nullopt);
}

TEST_CASE("Error_OfAFileThatIsTooShortOrMissing_NamesFileAndOffset") {
  const TemporaryDirectory here;
  const std::filesystem::path path = here.path() / "short";
  const Error missing = error_of([&] { File(path, OpenMode::kRead); });
  CHECK(missing.code() == ErrorCode::kNotFound);
  CHECK(missing.path() == path);
  File file(path, OpenMode::kCreate);
  std::vector<std::byte> bytes(10);
  file.write_at(0, bytes);
  const Error early = error_of([&] { file.read_at(4, bytes); });
  CHECK(early.code() == ErrorCode::kCorruption);
  CHECK(early.path() == path);
  CHECK(early.offset() == 10);
}

TEST_CASE("WithMemoryErrors_AllocationThatFails_IsOutOfMemory") {
  const auto code_of = [](auto work) {
    return error_of([&] { with_memory_errors("work", work); }).code();
  };
  CHECK(code_of([] { throw std::bad_alloc(); }) == ErrorCode::kOutOfMemory);
  CHECK(code_of([] { std::vector<int>().reserve(std::numeric_limits<std::size_t>::max()); }) ==
        ErrorCode::kOutOfMemory);
  CHECK(code_of([] { throw Error(ErrorCode::kBusy, "busy"); }) == ErrorCode::kBusy);
  CHECK(with_memory_errors("work", [] { return 7; }) == 7);
}

}  // namespace plait::test
