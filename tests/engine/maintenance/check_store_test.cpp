// check_store(): names every bad file, and finds none where Store::open finds none.
#include "plait/extend/check_store.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "engine/store/sample_store.h"
#include "plait/registry.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

/// Two attributes with levels 1 and 2, committed twice.
class Sample {
 public:
  explicit Sample(const std::string& backend) {
    Store store = Store::create(path(), BaseMesh::build(random_sheet(5, 60)),
                                sample_options(backend), default_backends());
    add_sample(store, sample_schemas()[0], 2);
    add_sample(store, sample_schemas()[5], 2);
    store.commit();
    commit_anew(store);
  }
  std::filesystem::path path() const { return directory_.path() / "s.plait"; }
  StoreCheck check() const { return check_store(path(), default_backends()); }
  bool opens() const {
    try {
      Store::open(path(), {.writable = false, .budget_bytes = 1 << 20}, default_backends());
      return true;
    } catch (const Error&) {
      return false;
    }
  }
  void flip(const std::string& name, std::uint64_t offset) const {
    const auto file = path() / name;
    overwrite_byte(file, offset, file_bytes(file)[offset] ^ std::byte{0x10});
  }

 private:
  TemporaryDirectory directory_;
};

std::set<std::string> names_of(const StoreCheck& check) {
  std::set<std::string> names;
  for (const DamagedFile& file : check.damaged) names.insert(file.name);
  return names;
}

const std::set<std::string> kOfVersion2 = {"attribute0.base.2",
                                           "attribute1.base.2",
                                           "attribute0.level01.1",
                                           "attribute0.level02.1",
                                           "attribute1.level01.1",
                                           "attribute1.level02.1",
                                           "base.mesh",
                                           "version.2"};

}  // namespace

TEST_CASE("Structure_OfAWholeStore_HasNothingToSay") {
  for (const std::string& backend : durable_backends()) {
    const Sample sample(backend);
    const StoreCheck check = sample.check();
    CHECK(check.damaged.empty());
    CHECK(check.left_over.empty());
    CHECK(check.notes.empty());
    CHECK(check.sequence == 2);
    CHECK(check.files == kOfVersion2.size() + 1);
    CHECK(check.options.backend == backend);
    CHECK(check.attributes.size() == 2);
    CHECK(check.base.edge_count() > 60);
  }
}

TEST_CASE("Structure_EachFileGoneShortOrFlipped_IsNamedAndOnlyThat") {
  for (const std::string& backend : durable_backends()) {
    const Sample sample(backend);
    for (const std::string& name : kOfVersion2) {
      CAPTURE(backend, name);
      const std::filesystem::path file = sample.path() / name;
      const std::vector<std::byte> bytes = file_bytes(file);
      std::filesystem::rename(file, sample.path() / "elsewhere");
      CHECK(names_of(sample.check()) == std::set{name});
      // Without the description nobody knows which names the version has.
      if (name != "version.2")
        CHECK(sample.check().left_over == std::vector<std::string>{"elsewhere"});
      CHECK_FALSE(sample.opens());
      std::filesystem::rename(sample.path() / "elsewhere", file);

      std::filesystem::resize_file(file, bytes.size() / 2);
      CHECK(names_of(sample.check()) == std::set{name});
      CHECK_FALSE(sample.opens());
      std::filesystem::resize_file(file, 0);
      File(file, OpenMode::kReadWrite).write_at(0, bytes);

      // A level's content is what a full verify reads.
      const bool level = name.find("level") != std::string::npos;
      for (const std::uint64_t offset : {std::size_t{0}, bytes.size() / 2, bytes.size() - 1}) {
        sample.flip(name, offset);
        CHECK(names_of(sample.check()) ==
              (level ? std::set<std::string>() : std::set<std::string>{name}));
        CHECK(sample.opens() == level);
        sample.flip(name, offset);
      }
    }
    CHECK(sample.opens());
  }
}

TEST_CASE("Structure_SeveralBadFiles_AreAllNamed") {
  for (const std::string& backend : durable_backends()) {
    const Sample sample(backend);
    const std::string version = "version.2";
    const auto file = sample.path() / version;
    std::filesystem::resize_file(file, std::filesystem::file_size(file) - 8);
    for (const std::string& name : kOfVersion2)
      if (name != version) std::filesystem::resize_file(sample.path() / name, 8);
    // Without base mesh and tables no size of a level is known.
    std::set<std::string> but_levels = kOfVersion2;
    std::erase_if(but_levels,
                  [](const std::string& name) { return name.find("level") != name.npos; });
    CHECK(names_of(sample.check()) == but_levels);
    for (const std::string& name : kOfVersion2)
      if (name != version) std::filesystem::remove(sample.path() / name);
    CHECK(names_of(sample.check()) == kOfVersion2);
    // Without the description no other file has a name.
    sample.flip(version, 40);
    CHECK(names_of(sample.check()) == std::set{version});
    CHECK(sample.check().damaged[0].kind == StoreFile::kDescription);
  }
}

TEST_CASE("Structure_WhatIsOddAndHarmless_IsNotedAndNoDamage") {
  const Sample sample("pread");
  for (const char* name : {"version.1", "attribute1.base.1"})
    std::filesystem::remove(sample.path() / name);
  CHECK(sample.check().damaged.empty());
  sample.flip("manifest", 4096 + 30);  // version 1
  StoreCheck check = sample.check();
  CHECK(check.sequence == 2);
  CHECK(check.damaged.empty());
  CHECK(check.left_over == std::vector<std::string>{"attribute0.base.1"});
  REQUIRE(check.notes.size() == 1);
  CHECK(check.notes[0].find("byte 4096 is damaged") != std::string::npos);

  sample.flip("manifest", 30);
  CHECK(error_of([&] { sample.check(); }).code() == ErrorCode::kCorruption);
  sample.flip("manifest", 4096 + 30);
  check = sample.check();
  CHECK(check.sequence == 1);
  REQUIRE(check.notes.size() == 1);
  CHECK(check.notes[0].find("a version 2 was begun or committed") != std::string::npos);
}

TEST_CASE("Structure_WhatIsNoStore_IsTheErrorOfOpening") {
  const TemporaryDirectory directory;
  CHECK(error_of([&] { check_store(directory.path() / "none", default_backends()); }).code() ==
        ErrorCode::kNotFound);
  CHECK(error_of([&] { check_store(directory.path(), default_backends()); }).code() ==
        ErrorCode::kNotFound);
}
