// Stores whose sizes somebody forged, with all checksums right again: they are refused before time
// or memory goes into what the sizes promise.
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <fstream>
#include <random>

#include "engine/store/forge.h"
#include "engine/store/sample_store.h"
#include "format/base_mesh_file.h"
#include "io/file_operations.h"
#include "io/machine.h"
#include "plait/extend/check_store.h"
#include "plait/registry.h"
#include "support/error_of.h"
#include "support/resource_limit.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

constexpr std::uint64_t kTiB = std::uint64_t{1} << 40;

/// Counts the bytes that are read while it lives.
class ReadBytes final : public FileOperationHook {
 public:
  ReadBytes() { set_file_operation_hook(this); }
  ~ReadBytes() { set_file_operation_hook(nullptr); }
  ReadBytes(const ReadBytes&) = delete;
  ReadBytes& operator=(const ReadBytes&) = delete;
  Verdict before(const FileOperation& operation) noexcept override {
    if (operation.kind == FileOperation::Kind::kRead) bytes_ += operation.bytes;
    return {};
  }
  void after(const FileOperation&) noexcept override {}
  std::uint64_t bytes() const { return bytes_; }

 private:
  std::atomic<std::uint64_t> bytes_ = 0;
};

struct ForgedStore {
  ForgedStore() {
    Store store = Store::create(path(), BaseMesh::build(icosahedron()), sample_options("pread"),
                                default_backends());
    add_sample(store, {"position", ComponentType::kFloat32, 3}, 1);
    store.commit();
  }
  std::filesystem::path path() const { return directory.path() / "s.plait"; }
  std::filesystem::path file(const std::string& name) const { return path() / name; }

  /// Opening and checking refuse it, name the file, say `words`, and read less than a megabyte.
  void is_refused(const std::string& name, const std::string& words) const {
    for (const bool writable : {false, true}) {
      const ReadBytes read;
      const Error error = error_of([&] {
        Store::open(path(), {.writable = writable, .budget_bytes = 1 << 20}, default_backends());
      });
      CHECK(error.code() == ErrorCode::kCorruption);
      CHECK(names(error, {file(name).string(), words}));
      CHECK(read.bytes() < 1 << 20);
    }
  }
  /// Likewise, and checking goes on with the next file.
  void is_found(const std::string& name, const std::string& words) const {
    const ReadBytes read;
    const StoreCheck check = check_store(path(), default_backends());
    CHECK(read.bytes() < 1 << 20);
    REQUIRE_FALSE(check.damaged.empty());
    CHECK(check.damaged.front().reason.find(file(name).string()) != std::string::npos);
    CHECK(check.damaged.front().reason.find(words) != std::string::npos);
  }

  TemporaryDirectory directory{Medium::kMemory};
};

/// A mesh of triangles apart from each other, all at one place: in a frame, it takes next to
/// nothing, except for `noise` bytes of its positions.
std::vector<std::byte> bomb(std::uint64_t faces, std::size_t noise = 0) {
  std::vector<std::byte> packed(28 * 3 * faces + 12 * faces);
  const std::size_t numbers = 12 * faces, coordinates = numbers + 12 * faces;
  // Numbers 0, 1, 2, ...: the first difference is 0, all others are 1, stored as 2.
  std::fill_n(packed.begin() + static_cast<std::ptrdiff_t>(numbers) + 1, 3 * faces - 1,
              std::byte{2});
  std::mt19937 random(1);
  std::generate_n(packed.begin() + static_cast<std::ptrdiff_t>(coordinates), noise,
                  [&] { return static_cast<std::byte>(random()); });
  return base_mesh_file(3 * faces, faces, {PositionForm::kFloat64, 0}, packed);
}

void forge_bomb(const ForgedStore& store, std::uint64_t faces) {
  const std::vector<std::byte> bytes = bomb(faces);
  write_whole(store.file("base.mesh"), bytes);
  forge_description(store.path(), [&](VersionDescription& version) {
    version.vertex_count = version.edge_count = version.border_edge_count = 3 * faces;
    version.face_count = faces;
    version.base_mesh_bytes = bytes.size();
    version.base_mesh_checksum = checksum_of(bytes);
  });
}

}  // namespace

TEST_CASE("BytesOnDisk_OfASparseFile_AreThoseOutsideItsHoles") {
  const TemporaryDirectory here{Medium::kMemory};
  File file(here.path() / "file", OpenMode::kCreate);
  CHECK(bytes_on_disk(file, 1) == 0);
  const std::array<std::byte, 4096> page{};
  file.write_at(0, page);
  file.write_at(1 << 30, page);
  file.resize(kTiB);
  const std::uint64_t found = bytes_on_disk(file, kTiB);
  CHECK((found >= 8192 && found <= 8 << 20));  // pages may be large
  CHECK(bytes_on_disk(file, 1) >= 4096);
}

TEST_CASE("SizesOfAVersion_OneThatTheDescriptionContradicts_IsRefusedUnread") {
  const ForgedStore store;
  std::filesystem::resize_file(store.file("version.1"), kTiB);
  Manifest manifest = read_manifest(Directory(store.path()));
  manifest.version_bytes = kTiB;
  {
    File file(store.file("manifest"), OpenMode::kReadWrite);
    write_manifest(file, manifest);
  }
  store.is_refused("version.1", "are a hole");
  store.is_found("version.1", "are a hole");
  // The disk has all of it, and the tables of one level cannot be so large.
  manifest.version_bytes = 100 << 20;
  std::filesystem::resize_file(store.file("version.1"), manifest.version_bytes);
  {
    File file(store.file("manifest"), OpenMode::kReadWrite);
    write_manifest(file, manifest);
  }
  store.is_refused("version.1", "bytes of block tables, expected 24");
  store.is_found("version.1", "bytes of block tables, expected 24");
}

TEST_CASE("SizesOfAVersion_CountsThatNoMeshHas_AreRefused") {
  const ForgedStore store;
  using Change = void (*)(VersionDescription&);
  for (const Change change : {Change([](VersionDescription& version) { ++version.edge_count; }),
                              Change([](VersionDescription& version) { --version.face_count; }),
                              Change([](VersionDescription& version) {
                                version.vertex_count = 3 * version.face_count + 1;
                              })}) {
    const std::vector<std::byte> before = whole_file(version_file(store.path()));
    forge_description(store.path(), change);
    const Error error = error_of([&] { Store::open(store.path(), {}, default_backends()); });
    CHECK(error.code() == ErrorCode::kCorruption);
    CHECK(names(error, {store.file("version.1").string(), "no mesh has"}));
    forge_version_file(store.path(), before);
  }
  Store::open(store.path(), {}, default_backends());
}

TEST_CASE("SizesOfBaseMeshAndRecords_ThatContradict_AreRefusedBeforeTheMeshIsMade") {
  const ForgedStore store;
  forge_bomb(store, 1'000'000);
  const auto forge_record_bytes = [&](std::uint64_t bytes) {
    forge_description(store.path(), [&](VersionDescription& version) {
      version.attributes[0].base_bytes = bytes;
    });
  };
  forge_record_bytes(36'000'000);
  // Whoever reads the mesh first finds it damaged.
  overwrite_byte(store.file("base.mesh"), 40, std::byte{0xa5});
  store.is_refused("attribute0.base.1", "144 bytes, expected 36000000");
  // Sparse records agree.
  std::filesystem::resize_file(store.file("attribute0.base.1"), 36'000'000);
  forge_description(store.path(), [](VersionDescription& version) {
    version.attributes[0].schema.type = ComponentType::kFloat64;
    version.attributes[0].schema.components = 255;
  });
  std::filesystem::resize_file(store.file("attribute0.base.1"), 3'000'000 * 255ull * 8);
  forge_record_bytes(3'000'000 * 255ull * 8);
  store.is_refused("attribute0.base.1", "are a hole");
  store.is_found("attribute0.base.1", "are a hole");
  // A packed file takes as much memory.
  std::filesystem::resize_file(store.file("attribute0.base.1"), 144);
  forge_record_bytes(144);
  store.is_refused("version.1", "packed base records of 5.70 GiB");
  store.is_found("version.1", "packed base records of 5.70 GiB");
}

TEST_CASE("SizeOfABaseMesh_BeyondTheMemory_IsRefusedByName") {
  if (!kAddressSpaceCanBeLimited) {
    SUCCEED("the sanitizer itself takes the address space");
    return;
  }
  const TemporaryDirectory here{Medium::kMemory};
  File file(here.path() / "base.mesh", OpenMode::kCreate);
  const std::uint64_t faces = 1'000'000;
  const std::vector<std::byte> bytes = bomb(faces, 1 << 16);
  file.write_at(0, bytes);
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  const ResourceLimit limit(
      RLIMIT_AS, pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE)) + (100 << 20));
  const Error error = error_of([&] {
    read_base_mesh_file(file, {bytes.size(), checksum_of(bytes)}, 3 * faces, faces);
  });
  CHECK(error.code() == ErrorCode::kOutOfMemory);
  CHECK(names(error, {file.path().string(), "3000000 vertices and 1000000 faces need at least"}));
}

TEST_CASE("SizeOfABaseMesh_FarBeyondWhatMeshesCompressTo_IsRefusedBeforeItIsDecoded") {
  const TemporaryDirectory here{Medium::kMemory};
  const std::uint64_t faces = 1'000'000;
  const std::vector<std::byte> bytes = bomb(faces);
  CHECK(bytes.size() < 16 << 10);
  File file(here.path() / "base.mesh", OpenMode::kCreate);
  file.write_at(0, bytes);
  const Error error = error_of([&] {
    read_base_mesh_file(file, {bytes.size(), checksum_of(bytes)}, 3 * faces, faces);
  });
  CHECK(error.code() == ErrorCode::kCorruption);
  CHECK(names(error, {file.path().string(), "expected a zstd frame of 96000000 bytes"}));
}

}  // namespace plait::test
