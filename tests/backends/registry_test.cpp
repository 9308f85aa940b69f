#include "plait/registry.h"

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
  for (const std::string name : {"tape", "", "pread:depth=8"})
    CHECK(error_text([&] { default_backends().find(name); }) ==
          "not_supported: open backend \"" + name +
              "\": expected one of compressed, memory, mmap, pread, uring; plug-ins add others "
              "(--plugin FILE, PLAIT_PLUGINS)");
}

TEST_CASE("BackendRegistryAdd_NameTaken_IsRefusedAndKeepsTheFirst") {
  BackendRegistry registry = default_backends();
  RegisteredBackend entry = registry.find("pread");
  entry.summary = "another";
  CHECK(error_text([&] { registry.add(entry); }).starts_with("invalid_argument: "));
  CHECK(registry.find("pread").summary != "another");
  entry.name = "mine";
  registry.add(entry);
  CHECK(registry.find("mine").summary == "another");
}

TEST_CASE("BackendRegistryAdd_EntryWithoutChecks_SuitsEveryMachineAndRefusesPipelines") {
  BackendRegistry registry;
  RegisteredBackend entry = default_backends().find("memory");
  entry.check_machine = nullptr;
  registry.add(entry);
  const RegisteredBackend& added = registry.find("memory");
  CHECK(error_text([&] { added.check_machine(); }).empty());
  CHECK(error_text([&] { added.check_pipelines("none", {}); }).empty());
  CHECK(error_text([&] { added.check_pipelines("lz4", {}); }) ==
        "invalid_argument: open backend \"memory\": expected pipeline \"none\", found \"lz4\"");
  entry.name = "cannot be opened";
  entry.open = nullptr;
  CHECK(error_text([&] { registry.add(entry); }) ==
        "invalid_argument: add backend \"cannot be opened\": expected a function that opens it");
}

TEST_CASE("CompressedCheckPipelines_UnknownCodecOrFilter_NamesThoseThereAre") {
  const auto validate = [](std::string_view pipeline) {
    default_backends().find("compressed").check_pipelines(pipeline, {});
  };
  for (const char* codec : {"none", "lz4", "zstd", "zstd:-131072", "zstd:0", "zstd:22"})
    CHECK(error_text([&] { validate(std::string("shuffle,") + codec); }).empty());
  CHECK(error_text([&] { validate("none,gzip"); }) ==
        "not_supported: choose codec \"gzip\" of pipeline \"none,gzip\": expected one of bitpack, "
        "lz4, "
        "none, zstd; plug-ins add others (--plugin FILE, PLAIT_PLUGINS)");
  CHECK(error_text([&] { validate("sort,lz4"); }) ==
        "not_supported: choose filter \"sort\" of pipeline \"sort,lz4\": expected one of "
        "columns, hierarchy, lattice, normals, shuffle; "
        "plug-ins add "
        "others "
        "(--plugin FILE, "
        "PLAIT_PLUGINS)");
  for (const char* codec : {"zstd:23", "zstd:-131073", "zstd:1x", "zstd: 1", "zstd:99999999999"})
    CHECK(error_text([&] {
            validate(std::string("none,") + codec);
          }).find("expected a level from -131072 to") != std::string::npos);
  for (const char* codec : {"LZ4", "zstdx"})
    CHECK(
        error_text([&] { validate(std::string("none,") + codec); }).starts_with("not_supported: "));
  for (const char* codec : {"", "lz4 ", "none:1", "zstd:"})
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
  backend.advise({0, 1}, Advice::kDontNeed);
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
