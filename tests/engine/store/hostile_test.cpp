// Stores that somebody has damaged: whatever byte of whatever file it is, the damage is found by
// opening, reading or verifying, or makes no difference.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <map>

#include "engine/store/forge.h"
#include "engine/store/sample_store.h"
#include "format/base_mesh_file.h"
#include "format/byte_order.h"
#include "format/checksum.h"
#include "format/manifest.h"
#include "format/packed_mesh.h"
#include "plait/digest.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/store_access.h"
#include "plait/registry.h"
#include "plait/verify.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

enum class Outcome {
  kRefused,       ///< by opening
  kFound,         ///< by reading and by verifying
  kOlderVersion,  ///< version 1 is there, whole
  kHarmless,
  kServed,  ///< wrong content, and nobody noticed
};

/// A small store of two versions: the second one adds a level, and an attribute whose level
/// was never written.
class Victim {
 public:
  explicit Victim(const std::string& backend) {
    Store store = Store::create(path(), BaseMesh::build(two_triangles()), sample_options(backend),
                                default_backends());
    add_sample(store, sample_schemas()[0], 0);
    store.commit();
    digests_[1] = digest(store);
    store.add_level(0);
    write_level(store, 0, 1, sample_level(store, sample_schemas()[0], 1));
    store.add_level(add_sample(store, {"part", ComponentType::kUint32, 1}, 0));
    store.commit();
    digests_[2] = digest(store);
  }

  std::filesystem::path path() const { return directory_.path() / "s.plait"; }

  /// Opens, reads and verifies everything.
  Outcome examine() const {
    try {
      Store store =
          Store::open(path(), {.writable = false, .budget_bytes = 1 << 20}, default_backends());
      const bool found_by_verify = verify(store).damaged_count > 0;
      bool found_by_reading = false, right = true;
      try {
        right = digest(store) == digests_.at(store.sequence());
      } catch (const Error& error) {
        REQUIRE(error.code() == ErrorCode::kCorruption);
        found_by_reading = true;
      }
      REQUIRE(found_by_reading == found_by_verify);
      if (found_by_reading) return Outcome::kFound;
      if (!right) return Outcome::kServed;
      return store.sequence() == 2 ? Outcome::kHarmless : Outcome::kOlderVersion;
    } catch (const Error& error) {
      REQUIRE((error.code() == ErrorCode::kCorruption || error.code() == ErrorCode::kNotFound ||
               error.code() == ErrorCode::kNotSupported));
      REQUIRE(names(error, {path().string()}));
      return Outcome::kRefused;
    }
  }

 private:
  TemporaryDirectory directory_;
  std::map<std::uint64_t, Digest> digests_;  ///< by version
};

/// What flipping a bit of byte `offset` must come to.
Outcome expected_of_flip(const std::string& name, std::uint64_t offset, const Store& store) {
  if (name == "manifest")
    return offset < kManifestSlotBytes ? Outcome::kOlderVersion : Outcome::kHarmless;
  if (name == "base.mesh" || name == "version.2" || name.ends_with(".base.2"))
    return Outcome::kRefused;
  const std::size_t dot = name.find(".level0");
  if (dot == std::string::npos) return Outcome::kHarmless;  // version 1, or the lock
  const LevelFile& file =
      StoreAccess::level_file(store, static_cast<AttributeId>(name[9] - '0'), name[dot + 7] - '0');
  const BlockEntry& entry = file.table[0];
  // A block that was never written is not read, whatever the file holds there: stored_bytes is 0.
  return offset < entry.stored_bytes ? Outcome::kFound : Outcome::kHarmless;
}

/// Replaces the base mesh, and enters its size and checksum.
void forge_base_mesh(const std::filesystem::path& store, std::span<const std::byte> bytes) {
  write_whole(store / "base.mesh", bytes);
  forge_description(store, [&](VersionDescription& version) {
    version.base_mesh_bytes = bytes.size();
    version.base_mesh_checksum = checksum_of(bytes);
  });
}

/// Whether the byte and the 64 bytes before it are zeros. There, one byte in 31 stands for the
/// rest.
bool is_deep_in_zeros(std::span<const std::byte> bytes, std::uint64_t offset) {
  return offset >= 64 && std::ranges::all_of(bytes.subspan(offset - 64, 65),
                                             [](std::byte byte) { return byte == std::byte{0}; });
}

}  // namespace

TEST_CASE("Store_AnyByteOfAnyFileFlipped_IsFoundOrHarmless") {
  for (const std::string& backend : durable_backends()) {
    const Victim victim(backend);
    REQUIRE(victim.examine() == Outcome::kHarmless);
    std::map<std::string, std::vector<Outcome>> expected;
    {
      const Store store = Store::open(victim.path(), {}, default_backends());
      for (const std::string& name : file_names(victim.path()))
        for (std::uint64_t offset = 0; offset < std::filesystem::file_size(victim.path() / name);
             ++offset)
          expected[name].push_back(expected_of_flip(name, offset, store));
    }
    REQUIRE(file_names(victim.path()).size() == 10);
    for (const auto& [name, outcomes] : expected) {
      const std::vector<std::byte> bytes = file_bytes(victim.path() / name);
      File file(victim.path() / name, OpenMode::kReadWrite);
      for (std::uint64_t offset = 0; offset < bytes.size(); ++offset) {
        if (is_deep_in_zeros(bytes, offset) && offset % 31 != 0) continue;
        const auto flipped = bytes[offset] ^ static_cast<std::byte>(1u << (offset % 8));
        file.write_at(offset, std::span(&flipped, 1));
        const Outcome outcome = victim.examine();
        file.write_at(offset, std::span(&bytes[offset], 1));
        if (outcome == outcomes[offset]) continue;
        INFO(backend << ": byte " << offset << " of " << name);
        REQUIRE(static_cast<int>(outcome) == static_cast<int>(outcomes[offset]));
      }
    }
    CHECK(victim.examine() == Outcome::kHarmless);
  }
}

TEST_CASE("Store_AnyFileCutGrownOrGone_IsFoundOrHarmless") {
  for (const std::string& backend : durable_backends()) {
    const Victim victim(backend);
    for (const std::string& name : file_names(victim.path())) {
      INFO(backend << ": " << name);
      const std::filesystem::path file = victim.path() / name;
      const std::vector<std::byte> bytes = file_bytes(file);
      // Files that version 2 does not need.
      const bool needed = name != "lock" && !name.ends_with(".1");
      // Between the last block and the end nothing is stored; and one slot of the manifest does.
      const bool slack = backend == "compressed" && name.find("level") != std::string::npos;
      for (const std::uint64_t size : {std::size_t{0}, std::size_t{1}, bytes.size() / 2,
                                       bytes.size() - 1, bytes.size() + 1, bytes.size() + 4096}) {
        if (size > bytes.size() + 4096) continue;  // one byte less than none
        std::filesystem::resize_file(file, size);
        const Outcome outcome = victim.examine();
        INFO("cut to " << size << " of " << bytes.size() << " bytes");
        CHECK(outcome != Outcome::kServed);
        if (!needed || size == bytes.size() || (name == "manifest" && size >= 4096) ||
            (slack && size > bytes.size()) || bytes.empty())
          CHECK(outcome == Outcome::kHarmless);
        else
          CHECK(outcome == Outcome::kRefused);
        std::filesystem::resize_file(file, 0);
        File(file, OpenMode::kReadWrite).write_at(0, bytes);
      }
      std::filesystem::rename(file, victim.path() / "elsewhere");
      CHECK(victim.examine() == (needed ? Outcome::kRefused : Outcome::kHarmless));
      std::filesystem::rename(victim.path() / "elsewhere", file);
    }
    CHECK(victim.examine() == Outcome::kHarmless);
  }
}

TEST_CASE("Store_BlocksExchangedTogetherWithTheirChecksums_AreFound") {
  for (const std::string& backend : durable_backends()) {
    const TemporaryDirectory directory;
    const std::filesystem::path path = directory.path() / "s.plait";
    {
      Store store = Store::create(path, BaseMesh::build(icosahedron()), sample_options(backend),
                                  default_backends());
      for (const char* name : {"one", "two"})
        add_sample(store, {name, ComponentType::kFloat32, 3}, 4);
      store.commit();
    }
    const auto examined = [&] {
      Store store = Store::open(path, {}, default_backends());
      return verify(store);
    };
    REQUIRE(examined().damaged_count == 0);
    const std::vector<std::byte> version = file_bytes(path / "version.1");
    const std::size_t begin = tables_offset(version);
    const std::size_t entries = (version.size() - begin) / sizeof(BlockEntry);
    // Per attribute one block for each of levels 1 and 2, two for level 3 and eight for level 4.
    REQUIRE(entries == 2 * (1 + 1 + 2 + 8));
    const auto entry_bytes = [&](std::vector<std::byte>& of, std::size_t entry) {
      return std::span(of).subspan(begin + entry * sizeof(BlockEntry), sizeof(BlockEntry));
    };
    struct Exchange {
      const char* first_file;
      std::size_t first;
      const char* second_file;
      std::size_t second;
    };
    for (const Exchange& exchange :
         {Exchange{"attribute0.level04.1", 4, "attribute0.level04.1", 5},      // another block
          Exchange{"attribute0.level04.1", 6, "attribute1.level04.1", 18}}) {  // another attribute
      std::vector<std::byte> forged = version;
      const auto first = entry_bytes(forged, exchange.first);
      const auto second = entry_bytes(forged, exchange.second);
      const auto first_entry = load<BlockEntry>(first, 0),
                 second_entry = load<BlockEntry>(second, 0);
      std::vector<std::byte> first_bytes(first_entry.stored_bytes);
      std::vector<std::byte> second_bytes(second_entry.stored_bytes);
      File first_file(path / exchange.first_file, OpenMode::kReadWrite);
      File second_file(path / exchange.second_file, OpenMode::kReadWrite);
      first_file.read_at(first_entry.offset, first_bytes);
      second_file.read_at(second_entry.offset, second_bytes);
      const std::vector<std::byte> files[] = {file_bytes(path / exchange.first_file),
                                              file_bytes(path / exchange.second_file)};
      first_file.write_at(first_entry.offset, second_bytes);
      second_file.write_at(second_entry.offset, first_bytes);
      std::swap_ranges(first.begin() + 8, first.end(), second.begin() + 8);  // all but offsets
      forge_version_file(path, forged);
      const VerifyReport report = examined();
      INFO(backend << ": " << exchange.first_file << " and " << exchange.second_file);
      CHECK(report.damaged_count == 2);
      first_file.write_at(0, files[0]);
      second_file.write_at(0, files[1]);
      forge_version_file(path, version);
      REQUIRE(examined().damaged_count == 0);
    }
  }
}

TEST_CASE("StoreOpen_TableEntryForgedWithTheRightChecksum_IsRefusedOrFound") {
  for (const std::string& backend : durable_backends()) {
    const Victim victim(backend);
    const std::vector<std::byte> version = file_bytes(victim.path() / "version.2");
    const std::size_t begin = tables_offset(version);
    REQUIRE(version.size() == begin + 2 * sizeof(BlockEntry));
    const auto examine_with = [&](std::size_t offset, auto value) {
      std::vector<std::byte> forged = version;
      save(std::span(forged), offset, value);
      forge_version_file(victim.path(), forged);
      return forged == version ? Outcome::kRefused : victim.examine();
    };
    for (std::size_t entry = begin; entry < version.size(); entry += sizeof(BlockEntry)) {
      INFO(backend << ": entry at byte " << entry);
      for (const std::uint64_t offset :
           {std::uint64_t{1}, std::uint64_t{512}, std::uint64_t{4096}, std::uint64_t{1} << 40,
            std::uint64_t{1} << 62, std::uint64_t{1} << 63, ~std::uint64_t{0}})
        CHECK(examine_with(entry, offset) == Outcome::kRefused);
      for (const std::uint32_t bytes : {1u, 511u, 4096u, 0x80000000u, 0xffffffffu}) {
        const Outcome outcome = examine_with(entry + 8, bytes);
        CHECK((outcome == Outcome::kRefused || outcome == Outcome::kFound));
      }
      for (const unsigned encoding : {0u, 1u, 2u, 3u, 0xffffu}) {
        const Outcome outcome = examine_with(entry + 12, static_cast<std::uint16_t>(encoding));
        CHECK((outcome == Outcome::kRefused || outcome == Outcome::kFound));
      }
      for (const unsigned file : {1u, 2u, 0xffffu})
        CHECK(examine_with(entry + 14, static_cast<std::uint16_t>(file)) == Outcome::kRefused);
      const Outcome outcome = examine_with(entry + 16, std::uint64_t{12345});
      CHECK((outcome == Outcome::kRefused || outcome == Outcome::kFound));
    }
    CHECK(examine_with(0, 'x') == Outcome::kRefused);
    CHECK(examine_with(8, 2u) == Outcome::kRefused);
    for (const std::size_t size :
         {version.size() - 24, version.size() - 1, version.size() + 1, version.size() + 24, begin,
          begin - 1, std::size_t{32}, std::size_t{31}, std::size_t{0}}) {
      std::vector<std::byte> forged = version;
      forged.resize(size);
      forge_version_file(victim.path(), forged);
      CHECK(victim.examine() == Outcome::kRefused);
    }
    forge_version_file(victim.path(), version);
    CHECK(victim.examine() == Outcome::kHarmless);
  }
}

TEST_CASE("StoreOpen_LevelForgedTooLargeToBe_IsRefused") {
  const TemporaryDirectory here;
  const std::filesystem::path path = here.path() / "s.plait";
  {
    Store store = Store::create(path, BaseMesh::build(torus_grid(100, 70)), sample_options("pread"),
                                default_backends());
    store.add_attribute({"wide", ComponentType::kFloat64, 255});
    store.commit();
  }
  forge_description(path, [](VersionDescription& version) {
    version.attributes[0].levels.resize(kMaxLevel, {"none", Representation::kValues, 1});
  });
  const Error error = error_of([&] { Store::open(path, {}, default_backends()); });
  CHECK(error.code() == ErrorCode::kCorruption);
}

TEST_CASE("StoreOpen_BaseMeshForgedWithTheRightChecksum_IsRefused") {
  const Victim victim("pread");
  const std::vector<std::byte> file = file_bytes(victim.path() / "base.mesh");
  const auto examine = [&](std::span<const std::byte> forged) {
    forge_base_mesh(victim.path(), forged);
    return victim.examine();
  };
  const auto refused = [&](std::size_t offset, auto value) {
    std::vector<std::byte> forged = file;
    save(std::span(forged), offset, value);
    return examine(forged) == Outcome::kRefused;
  };
  CHECK(refused(0, 'x'));
  CHECK(refused(8, 1u));
  CHECK(refused(32, 'x'));
  for (const std::uint64_t count :
       {std::uint64_t{0}, std::uint64_t{3}, std::uint64_t{1} << 31, std::uint64_t{1} << 32,
        std::uint64_t{1} << 40, std::uint64_t{1} << 61, ~std::uint64_t{0}}) {
    CHECK(refused(16, count));
    CHECK(refused(24, count));
    // The description says the same. A file of so few bytes cannot have so many vertices, and none
    // of their memory is taken.
    std::vector<std::byte> forged = file;
    save(std::span(forged), 16, count);
    write_whole(victim.path() / "base.mesh", forged);
    const std::vector<std::byte> version = whole_file(version_file(victim.path()));
    forge_description(victim.path(), [&](VersionDescription& description) {
      description.vertex_count = count;
      description.base_mesh_bytes = forged.size();
      description.base_mesh_checksum = checksum_of(forged);
    });
    CHECK(victim.examine() == Outcome::kRefused);
    forge_version_file(victim.path(), version);
  }
  for (const std::size_t bytes :
       {std::size_t{0}, std::size_t{31}, std::size_t{32}, std::size_t{40}, file.size() - 1})
    CHECK(examine(std::span(file).first(bytes)) == Outcome::kRefused);
  std::vector<std::byte> longer = file;
  longer.push_back(std::byte{0});
  CHECK(examine(longer) == Outcome::kRefused);
  longer.insert(longer.end() - 1, file.begin() + 40, file.end());  // a second frame, and a byte
  CHECK(examine(longer) == Outcome::kRefused);
  CHECK(examine(file) == Outcome::kHarmless);

  const BaseMesh mesh = Store::open(victim.path(), {}, default_backends()).base();
  const std::uint64_t vertices = mesh.vertex_count(), faces = mesh.face_count();
  const PositionWords words{PositionForm::kFloat64, 0};
  const std::vector<std::byte> packed = pack_mesh(mesh, words);
  const auto forged = [&](const auto& change) {
    std::vector<std::byte> bytes = packed;
    change(std::span(bytes));
    return examine(base_mesh_file(vertices, faces, words, bytes));
  };
  CHECK(forged([](auto) {}) == Outcome::kHarmless);
  CHECK(examine(base_mesh_file(vertices, faces, words,
                               std::span(packed).first(packed.size() - 1))) == Outcome::kRefused);
  CHECK(refused(32, 0u));
  CHECK(refused(32, 4u));
  CHECK(refused(36, 901));
  CHECK(refused(36, -1001));
  const std::size_t codes = 0, numbers = 12 * faces, coordinates = numbers + 4 * vertices;
  // The first x becomes the highest of all places: a NaN.
  CHECK(forged([&](auto bytes) {
          for (std::size_t plane = 0; plane < 8; ++plane)
            bytes[coordinates + plane * vertices] = plane == 0 ? std::byte{1} : std::byte{0};
        }) == Outcome::kRefused);
  // The planes of the lowest bytes of codes and numbers. A vertex too many, too few, too far
  // behind.
  for (std::size_t corner = 0; corner < 3 * faces; ++corner)
    for (const int code : {0, 1, 2, 3, 4, 5, 255}) {
      const bool was_new = packed[codes + corner] == std::byte{0};
      if (was_new == (code == 0) && code != 255) continue;
      CAPTURE(corner, code);
      CHECK(forged([&](auto bytes) { bytes[codes + corner] = static_cast<std::byte>(code); }) ==
            Outcome::kRefused);
    }
  CHECK(forged([&](auto bytes) { bytes[codes + 9 * faces] = std::byte{0xff}; }) ==
        Outcome::kRefused);
  CHECK(forged([&](auto bytes) { bytes[numbers] = std::byte{200}; }) == Outcome::kRefused);
  CHECK(forged([&](auto bytes) { bytes[numbers + 1] = std::byte{0}; }) == Outcome::kRefused);
}

TEST_CASE("StoreOpen_ManifestForgedWithTheRightChecksum_IsRefused") {
  for (const std::string& backend : durable_backends()) {
    const Victim victim(backend);
    const Manifest right = read_manifest(Directory(victim.path()));
    const auto outcome = [&](const std::function<void(Manifest&)>& change) {
      Manifest manifest = right;
      change(manifest);
      File file(victim.path() / "manifest", OpenMode::kReadWrite);
      write_manifest(file, manifest);
      return victim.examine();
    };
    const std::function<void(Manifest&)> changes[] = {
        [](Manifest& m) { m.sequence = 4; },
        [](Manifest& m) { m.version_bytes = ~std::uint64_t{0}; },
        [](Manifest& m) { m.version_bytes = 0; },
        [](Manifest& m) { ++m.version_bytes; },
        [](Manifest& m) { ++m.version_checksum; },
    };
    for (std::size_t i = 0; i < std::size(changes); ++i) {
      INFO(backend << ": change " << i);
      CHECK(outcome(changes[i]) == Outcome::kRefused);
    }
    // Another store's block: the right bytes of somebody else.
    CHECK(outcome([](Manifest& m) { m.uuid[3] ^= std::byte{1}; }) == Outcome::kFound);
    CHECK(outcome([](Manifest&) {}) == Outcome::kHarmless);
  }
}

namespace {

/// A pipeline whose text ends with `text`, which no pipeline's does.
Pipeline with_behind(Pipeline pipeline, const char* text) {
  pipeline.codec.name += text;
  return pipeline;
}

}  // namespace

TEST_CASE("StoreOpen_DescriptionForgedWithTheRightChecksum_IsRefused") {
  for (const std::string& backend : durable_backends()) {
    const Victim victim(backend);
    const std::vector<std::byte> right = file_bytes(victim.path() / "version.2");
    using Change = std::function<void(VersionDescription&)>;
    const auto outcome = [&](const Change& change) {
      forge_description(victim.path(), change);
      const Outcome result = victim.examine();
      forge_version_file(victim.path(), right);
      return result;
    };
    const LevelRecord level{"none", Representation::kValues, 2};
    const Change changes[] = {
        [](auto& v) { ++v.vertex_count; },
        [](auto& v) { v.edge_count = 1u << 31; },
        [](auto& v) { ++v.face_count; },
        [](auto& v) { --v.border_edge_count; },
        [](auto& v) { v.provenance.base_level = 1; },
        [](auto& v) { v.base_mesh_bytes = ~std::uint64_t{0}; },
        [](auto& v) { v.base_mesh_bytes = 1; },
        [](auto& v) { v.backend = "tape"; },
        [](auto& v) { v.backend = "memory"; },
        [](auto& v) { v.backend = ""; },
        [](auto& v) { v.backend += ":depth=8"; },
        [](auto& v) { v.pipeline = "rar"; },
        [](auto& v) { v.attributes[0].pipeline = "rar"; },
        [](auto& v) { v.attributes[0].levels[0].pipeline = "shuffle,rar"; },
        [](auto& v) {
          v.attributes[0].pipeline = with_behind(v.attributes[0].pipeline.of(0), ";@3");
        },
        [](auto& v) {
          v.attributes[0].pipeline = with_behind(v.attributes[0].pipeline.of(0), ";@3=rar");
        },
        [](auto& v) {
          v.attributes[0].levels[0].pipeline =
              with_behind(v.attributes[0].levels[0].pipeline, ";@1=none");
        },
        [](auto& v) { v.attributes[0].levels[0].generation = 1; },
        [](auto& v) { v.attributes[0].levels[0].generation = 3; },
        [](auto& v) { v.attributes[0].levels[0].representation = Representation{9}; },
        [&](auto& v) { v.attributes[0].levels.resize(20, level); },
        [](auto& v) { v.attributes[0].levels.clear(); },
        [&](auto& v) { v.attributes[1].levels.resize(2, level); },
        [](auto& v) { v.attributes[0].schema.type = ComponentType::kUint64; },
        [](auto& v) { v.attributes[0].schema.components = 255; },
        [](auto& v) { std::swap(v.attributes[0], v.attributes[1]); },
        [](auto& v) {
          v.attributes[1].number = 7;
          v.next_attribute_number = 8;
        },
        [](auto& v) { v.attributes.pop_back(); },
        [](auto& v) {
          v.attributes.push_back(v.attributes[0]);
          v.attributes[2].schema.name = "third";
          v.attributes[2].number = v.next_attribute_number++;
        },
    };
    for (std::size_t i = 0; i < std::size(changes); ++i) {
      INFO(backend << ": change " << i);
      CHECK(outcome(changes[i]) == Outcome::kRefused);
    }
    CHECK(outcome([](VersionDescription&) {}) == Outcome::kHarmless);
  }
}
