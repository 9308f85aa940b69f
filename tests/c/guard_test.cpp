// What stands between the C interface and the C++ library: exceptions become codes, and structures
// of other versions are understood or refused.
#include "guard.h"

#include <array>
#include <catch2/catch.hpp>
#include <new>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>

#include "plait.h"
#include "plait/extend/provenance.h"
#include "plait/options.h"
#include "plait/registry.h"
#include "plait/subdivide.h"
#include "sized.h"

using namespace plait;

namespace {

/// A structure as the first version of an interface had it, and as a later version has it.
struct FirstOptions {
  std::size_t struct_size;
  std::uint64_t count;
};
struct LaterOptions {
  std::size_t struct_size;
  std::uint64_t count;
  std::uint64_t added;
};
constexpr LaterOptions kDefaults{sizeof(LaterOptions), 5, 77};

}  // namespace

TEST_CASE("Guard_EachErrorCode_HasItsNumberAndItsName") {
  const std::array<std::pair<ErrorCode, int>, 11> numbers{{{ErrorCode::kNotFound, 1},
                                                           {ErrorCode::kInvalidArgument, 2},
                                                           {ErrorCode::kCorruption, 3},
                                                           {ErrorCode::kNotSupported, 4},
                                                           {ErrorCode::kIo, 5},
                                                           {ErrorCode::kNoSpace, 6},
                                                           {ErrorCode::kOutOfMemory, 7},
                                                           {ErrorCode::kBudget, 8},
                                                           {ErrorCode::kBusy, 9},
                                                           {ErrorCode::kBadState, 10},
                                                           {ErrorCode::kCancelled, 11}}};
  for (const auto& [code, number] : numbers) {
    const ErrorCode thrown = code;
    CHECK(c::guarded("call", [&] { throw Error(thrown, "the reason"); }) == number);
    CHECK(plait_error_message() == std::string("call: the reason"));
    CHECK(plait_status_name(number) == std::string(to_string(code)));
  }
  CHECK(plait_status_name(PLAIT_OK) == std::string("ok"));
  CHECK(plait_status_name(99) == std::string("unknown"));
  CHECK(to_string(static_cast<ErrorCode>(11)) == to_string(static_cast<ErrorCode>(200)));
}

TEST_CASE("Guard_ErrorAboutAFile_HasItsPathAndOffset") {
  c::guarded("call", [] { throw Error(ErrorCode::kIo, "no reason").about("/x/y", 17); });
  CHECK(plait_error_path() == std::string("/x/y"));
  CHECK(plait_error_offset() == 17);
  c::guarded("call", [] { throw Error(ErrorCode::kIo, "no reason").about("/x/z"); });
  CHECK(plait_error_path() == std::string("/x/z"));
  CHECK(plait_error_offset() == PLAIT_NO_OFFSET);
  c::guarded("call", [] { throw std::bad_alloc(); });
  CHECK(plait_error_path() == std::string());
}

TEST_CASE("Guard_OtherExceptions_BecomeCodesToo") {
  CHECK(c::guarded("call", [] { throw std::bad_alloc(); }) == PLAIT_ERROR_OUT_OF_MEMORY);
  CHECK(c::guarded("call", [] { throw std::length_error("vector"); }) == PLAIT_ERROR_OUT_OF_MEMORY);
  CHECK(c::guarded("call", [] { throw std::logic_error("odd"); }) == PLAIT_ERROR_INTERNAL);
  CHECK(plait_error_message() == std::string("call: odd"));
  CHECK(c::guarded("call", [] { throw 5; }) == PLAIT_ERROR_INTERNAL);
  CHECK(c::guarded("call", [] {}) == PLAIT_OK);
  CHECK(plait_error_message() == std::string("call: an exception of an unknown type"));
}

TEST_CASE("Sized_OptionsOfAnEarlierVersion_GetTheDefaultsOfNewMembers") {
  const FirstOptions first{sizeof(FirstOptions), 9};
  LaterOptions given = kDefaults;
  std::memcpy(&given, &first, sizeof(first));
  given.added = 123;  // memory behind the earlier structure, which is not the program's
  const LaterOptions options = c::options_of(&given, kDefaults, sizeof(FirstOptions));
  CHECK(options.count == 9);
  CHECK(options.added == 77);
  CHECK(c::options_of<LaterOptions>(nullptr, kDefaults).count == 5);
  given.struct_size = sizeof(FirstOptions) - 1;
  CHECK_THROWS_AS(c::options_of(&given, kDefaults, sizeof(FirstOptions)), Error);
}

TEST_CASE("Sized_ResultOfAnEarlierVersion_IsNotWrittenBeyondItsEnd") {
  LaterOptions into{sizeof(FirstOptions), 0, 123};
  c::check_result(&into, "into", sizeof(FirstOptions));
  c::fill(&into, LaterOptions{sizeof(LaterOptions), 4, 5});
  CHECK(into.struct_size == sizeof(FirstOptions));
  CHECK(into.count == 4);
  CHECK(into.added == 123);
}

TEST_CASE("Sized_DefaultsOfOptions_AreThoseOfCpp") {
  CHECK(plait_store_options(PLAIT_STORE_OPTIONS_INIT).block_bytes == StoreOptions().block_bytes);
  CHECK(PLAIT_DEFAULT_BUDGET_BYTES == StoreOptions().budget_bytes);
  CHECK(PLAIT_DEFAULT_BUDGET_BYTES == OpenOptions().budget_bytes);
  const plait_subdivide_options work = PLAIT_SUBDIVIDE_OPTIONS_INIT;
  CHECK(work.levels == SubdivideOptions().levels);
  CHECK(work.threads == SubdivideOptions().threads);
}

TEST_CASE("BuildInfo_NamesEachBackendCodecAndFilter") {
  CHECK(plait_abi_version() == PLAIT_ABI_VERSION);
  CHECK(plait_version_string() == program_version());
  std::istringstream lines(plait_build_info());
  std::string line, all;
  while (std::getline(lines, line)) {
    CHECK(line.find(": ") != std::string::npos);
    all += line + " \n";
  }
  for (const auto& names : {default_backends().names(), default_pipelines().codec_names(),
                            default_pipelines().filter_names()})
    for (const std::string& name : names) CHECK(all.find(' ' + name + ' ') != std::string::npos);
  for (const char* name : {" loop ", " midpoint ", " fused ", " hilbert ", " auto "})
    CHECK(all.find(name) != std::string::npos);
}

// A program of today may pass its structures to any later library, so their sizes stay as they are:
// a new member is added at the end, and this number becomes the smallest size that is accepted.
static_assert(sizeof(plait_store_options) == 136);
static_assert(sizeof(plait_open_options) == 72);
static_assert(sizeof(plait_store_info) == 168);
static_assert(sizeof(plait_attribute_info) == 40);
static_assert(sizeof(plait_paging_statistics) == 96);
static_assert(sizeof(plait_subdivide_options) == 72);
static_assert(sizeof(plait_verify_report) == 40);
static_assert(sizeof(plait_damaged_block) == 56);
static_assert(sizeof(plait_reader_options) == 40);
static_assert(sizeof(plait_view_info) == 32);
