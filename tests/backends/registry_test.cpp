#include "plait/backends/registry.h"

#include <catch2/catch.hpp>

#include "backends/conformance.h"
#include "plait/error.h"
#include "support/counting_backend.h"

namespace plait::test {
namespace {

/// "code: message" of the Error that `call` throws, or "".
template <class Call>
std::string error_text(Call&& call) {
  try {
    call();
  } catch (const Error& error) {
    return std::string(to_string(error.code())) + ": " + error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("DefaultBackends_Names_AreTheFive") {
  CHECK(default_backends().names() ==
        std::vector<std::string>{"compressed", "memory", "mmap", "pread", "uring"});
}

TEST_CASE("BackendRegistryFind_UnknownName_NamesThoseThereAre") {
  CHECK(error_text([] { default_backends().find("tape"); }) ==
        "not_supported: open backend \"tape\": expected one of compressed, memory, mmap, pread, "
        "uring; plug-ins add others (--plugin FILE, PLAIT_PLUGINS)");
}

TEST_CASE("BackendRegistryAdd_NameTaken_IsRefusedAndKeepsTheFirst") {
  BackendRegistry registry = default_backends();
  BackendRegistry::Entry entry = registry.find("pread");
  entry.summary = "another";
  CHECK(error_text([&] { registry.add(entry); }).starts_with("invalid_argument: "));
  CHECK(registry.find("pread").summary != "another");
  entry.name = "mine";
  registry.add(entry);
  CHECK(registry.find("mine").summary == "another");
}

TEST_CASE("BackendRegistryAdd_EntryWithoutValidate_RefusesOptionsAndPipelines") {
  BackendRegistry registry;
  BackendRegistry::Entry entry = default_backends().find("memory");
  entry.validate = nullptr;
  entry.validate_pipeline = nullptr;
  registry.add(entry);
  const BackendRegistry::Entry& added = registry.find("memory");
  CHECK(error_text([&] { added.validate(""); }).empty());
  CHECK(error_text([&] { added.validate("speed=high"); }) ==
        "invalid_argument: open backend \"memory\": expected no options, found \"speed=high\"");
  CHECK(error_text([&] { added.validate_pipeline("none", {}); }).empty());
  CHECK(error_text([&] { added.validate_pipeline("lz4", {}); }) ==
        "invalid_argument: open backend \"memory\": expected pipeline \"none\", found \"lz4\"");
  entry.name = "cannot be opened";
  entry.open = nullptr;
  CHECK(error_text([&] { registry.add(entry); }) ==
        "invalid_argument: add backend \"cannot be opened\": expected a function that opens it");
}

TEST_CASE("BackendRegistryFind_SpecificationWithOptions_IsFoundByItsName") {
  CHECK(default_backends().find("pread:depth=8").name == "pread");
  CHECK(BackendRegistry::options_in("pread:depth=8,direct=yes") == "depth=8,direct=yes");
  CHECK(BackendRegistry::options_in("pread").empty());
  for (const std::string& name : default_backends().names())
    CHECK_FALSE(error_text([&] { default_backends().find(name).validate("depth=8"); }).empty());
}

TEST_CASE("CompressedValidatePipeline_UnknownCodecOrFilter_NamesThoseThereAre") {
  const auto validate = [](std::string_view pipeline) {
    default_backends().find("compressed").validate_pipeline(pipeline, {});
  };
  for (const char* codec : {"none", "lz4", "zstd", "zstd:-131072", "zstd:0", "zstd:22"})
    CHECK(error_text([&] { validate(std::string("shuffle,") + codec); }).empty());
  CHECK(error_text([&] { validate("none,gzip"); }) ==
        "not_supported: choose codec \"gzip\" of pipeline \"none,gzip\": expected one of bitpack, "
        "lz4, "
        "none, zstd; plug-ins add others (--plugin FILE, PLAIT_PLUGINS)");
  CHECK(error_text([&] { validate("sort,lz4"); }) ==
        "not_supported: choose filter \"sort\" of pipeline \"sort,lz4\": expected one of "
        "bytedelta, columns, hierarchy, lattice, lorenzo, normals, parallelogram, shuffle; "
        "plug-ins add "
        "others "
        "(--plugin FILE, "
        "PLAIT_PLUGINS)");
  for (const char* codec : {"zstd:23", "zstd:-131073", "zstd:1x", "zstd: 1", "zstd:99999999999"})
    CHECK(error_text([&] {
            validate(std::string("none,") + codec);
          }).find("expected a level from -131072 to") != std::string::npos);
  for (const char* codec : {"", "LZ4", "lz4 ", "zstdx"})
    CHECK(
        error_text([&] { validate(std::string("none,") + codec); }).starts_with("not_supported: "));
  for (const char* codec : {"none:1", "zstd:"})
    CHECK(error_text([&] {
            validate(std::string("none,") + codec);
          }).starts_with("invalid_argument: "));
}

TEST_CASE("CountingBackend_Calls_AreCountedAndForwarded") {
  BackendCounts counts;
  const BackendRegistry registry = counting_registry(default_backends(), counts);
  const BackendUnderTest subject{"counted", registry.find("pread")};
  LevelUnderTest level(subject);
  Backend& backend = level.open();
  const std::vector<std::byte> bytes =
      make_content(level.geometry().range_bytes(1, 2), Content::kRandom, 1);
  backend.write({1, 2}, bytes);
  CHECK(read_blocks(backend, level.geometry(), {1, 2}) == bytes);
  backend.advise({0, 1}, Advice::kWillNeed);
  backend.sync(true);
  CHECK(counts.write_calls == 1);
  CHECK(counts.write_blocks == 2);
  CHECK(counts.write_bytes == bytes.size());
  CHECK(counts.read_calls == 1);
  CHECK(counts.read_blocks == 2);
  CHECK(counts.read_bytes == bytes.size());
  CHECK(counts.advise_calls == 1);
  CHECK(counts.sync_calls == 1);
}

}  // namespace plait::test
