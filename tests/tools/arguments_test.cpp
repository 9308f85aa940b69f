#include "arguments.h"

#include <catch2/catch.hpp>
#include <limits>
#include <string>
#include <vector>

#include "base/text.h"
#include "nearest_name.h"
#include "plait/error.h"
#include "progress.h"

namespace plait {
namespace {

ErrorCode refusal_of_size(const std::string& text) {
  try {
    parse_size(text);
  } catch (const Error& error) {
    return error.code();
  }
  return ErrorCode::kBadState;
}

}  // namespace

TEST_CASE("ParseSize_UnitsInAnyCase_ArePowersOf1024") {
  CHECK(parse_size("0") == 0);
  CHECK(parse_size("65537") == 65537);
  CHECK(parse_size("512B") == 512);
  for (const char* text : {"64K", "64k", "64KiB", "64kib", "64KB", "64 KiB"})
    CHECK(parse_size(text) == 64u << 10);
  for (const char* text : {"3M", "3MiB", "3mb"}) CHECK(parse_size(text) == 3u << 20);
  CHECK(parse_size("2GiB") == std::uint64_t{2} << 30);
  CHECK(parse_size("1.5G") == std::uint64_t{3} << 29);
  CHECK(parse_size("0.25K") == 256);
  for (const char* text : {"1T", "1TiB", "1tb", "1024G"})
    CHECK(parse_size(text) == std::uint64_t{1} << 40);
  CHECK(parse_size("0.001953125T") == std::uint64_t{2} << 30);
}

TEST_CASE("ParseSize_LargestValues_FitOrAreRefused") {
  CHECK(parse_size("18446744073709551615") == std::numeric_limits<std::uint64_t>::max());
  CHECK(parse_size("17179869183G") == std::uint64_t{17179869183} << 30);
  CHECK(refusal_of_size("18446744073709551616") == ErrorCode::kInvalidArgument);
  CHECK(refusal_of_size("17179869184G") == ErrorCode::kInvalidArgument);
}

TEST_CASE("ParseSize_Junk_IsRefused") {
  for (const char* text :
       {"",     " ",     "K",     "-1",    "+1",    "1e6",     "0x10",          "12P",
        "12KK", "12Ki",  "1.",    ".5K",   "1.5",   "1.0001K", "1.1234567891K", "12 ",
        " 12",  "12  K", "1,000", "1_000", "12K\n", "NaN"}) {
    CAPTURE(text);
    CHECK(refusal_of_size(text) == ErrorCode::kInvalidArgument);
  }
}

TEST_CASE("ParseWholeNumber_OutsideItsRange_IsRefusedNamingIt") {
  CHECK(parse_whole_number("0", 0, 20) == 0);
  CHECK(parse_whole_number("20", 0, 20) == 20);
  CHECK(parse_whole_number("18446744073709551615", 0, std::numeric_limits<std::uint64_t>::max()) ==
        std::numeric_limits<std::uint64_t>::max());
  for (const std::string text :
       {"", "-1", "-0", "+1", "21", "1.0", " 1", "1e1", "99999999999999999999"}) {
    CAPTURE(text);
    CHECK_THROWS_WITH(parse_whole_number(text, 0, 20),
                      "expected a whole number from 0 to 20, found \"" + text + "\"");
  }
}

TEST_CASE("NearestName_OneOrTwoSlips_IsTheNameMeant") {
  const std::vector<std::string> names = {"generate", "subdivide", "info", "verify", "digest"};
  CHECK(nearest_name("subdvide", names) == "subdivide");
  CHECK(nearest_name("sbudivide", names) == "subdivide");
  CHECK(nearest_name("inof", names) == "info");
  CHECK(nearest_name("digests", names) == "digest");
  CHECK(nearest_name("foo", names).empty());
  CHECK(nearest_name("in", names).empty());
  CHECK(nearest_name("", names).empty());
  CHECK(nearest_name(std::string(100000, 'x'), names).empty());
}

TEST_CASE("SizeText_AnySize_ReadsBack") {
  for (const std::uint64_t bytes :
       {std::uint64_t{0}, std::uint64_t{1}, std::uint64_t{1024}, std::uint64_t{1536},
        std::uint64_t{1} << 20, std::uint64_t{5} << 40}) {
    CAPTURE(bytes);
    CHECK(parse_size(size_text(bytes)) == bytes);
  }
  CHECK(size_text(1 << 20) == "1MiB");
}

TEST_CASE("FormatCount_AnyCount_HasGroupsOfThree") {
  CHECK(format_count(0) == "0");
  CHECK(format_count(999) == "999");
  CHECK(format_count(1000) == "1,000");
  CHECK(format_count(26640386) == "26,640,386");
}

TEST_CASE("ShellWord_CharactersOfTheShell_AreInQuotes") {
  CHECK(shell_word("out/bunny-1.plait") == "out/bunny-1.plait");
  CHECK(shell_word("--compress=position=zstd:3") == "--compress=position=zstd:3");
  CHECK(shell_word("") == "''");
  CHECK(shell_word("two words") == "'two words'");
  CHECK(shell_word("$HOME;") == "'$HOME;'");
  CHECK(shell_word("it's") == "'it'\\''s'");
}

TEST_CASE("FormatBytes_AnySize_HasThreeDigitsAndAUnit") {
  CHECK(format_bytes(1023) == "1023 bytes");
  CHECK(format_bytes(1536) == "1.50 KiB");
  CHECK(format_bytes(std::uint64_t{640} << 20) == "640 MiB");
  CHECK(format_bytes(std::numeric_limits<std::uint64_t>::max()) == "16.0 EiB");
}

TEST_CASE("ProgressLine_HalfWay_ShowsBarRateAndTimeLeft") {
  const std::string line = progress_line("subdivide", "level 3", ProgressUnit::kVertices,
                                         50'000'000, 100'000'000, 10, 120);
  CHECK(line == "subdivide  level 3 [############............]  50%  5.0 M vertices/s  0:10 left");
}

TEST_CASE("ProgressLine_StartEndAndNarrowTerminal_StaysInBounds") {
  CHECK(progress_line("verify", "", ProgressUnit::kBytes, 0, 0, 0, 80) ==
        "verify [........................]   0%");
  CHECK(progress_line("verify", "", ProgressUnit::kBytes, 9, 8, 1, 80).find("100%") !=
        std::string::npos);
  CHECK(progress_line("verify", "", ProgressUnit::kBytes, 4, 8, 1, 10).size() == 10);
}

}  // namespace plait
