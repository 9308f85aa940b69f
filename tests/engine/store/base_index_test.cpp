// Stores with the file base.index: who makes it, who reads how much of it, and what happens when it
// is damaged.
#include <algorithm>
#include <catch2/catch.hpp>
#include <optional>
#include <thread>

#include "engine/store/sample_store.h"
#include "plait/digest.h"
#include "plait/extend/check_store.h"
#include "plait/reader.h"
#include "plait/registry.h"
#include "plait/verify.h"
#include "support/answering_operations.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

const AttributeSchema kPosition{"position", ComponentType::kFloat32, 3};

/// The bytes that are read from base.mesh and from base.index while it lives.
class BaseReads {
 public:
  std::uint64_t mesh() const { return mesh_; }
  std::uint64_t index() const { return index_; }

 private:
  std::atomic<std::uint64_t> mesh_ = 0, index_ = 0;
  AnsweringOperations counting_{[this](const FileOperation& operation) {
    if (operation.kind != FileOperation::Kind::kRead) return 0;
    if (operation.path.filename() == "base.mesh") mesh_ += operation.bytes;
    if (operation.path.filename() == "base.index") index_ += operation.bytes;
    return 0;
  }};
};

/// A store in a temporary directory, committed once.
class Made {
 public:
  explicit Made(const std::string& backend, std::optional<bool> base_index,
                IndexedMesh mesh = side_by_side({torus_grid(60, 60), random_sheet(4, 60)})) {
    StoreOptions options = sample_options(backend);
    options.base_index = base_index;
    Store store =
        Store::create(path(), BaseMesh::build(std::move(mesh)), options, default_backends());
    add_sample(store, kPosition, 1);
    store.commit();
  }
  std::filesystem::path path() const { return directory_.path() / "s.plait"; }
  std::filesystem::path index() const { return path() / "base.index"; }
  bool has_index() const { return std::filesystem::exists(index()); }
  Store open(bool writable = false, std::optional<bool> base_index = {}) const {
    const OpenOptions options{
        .writable = writable, .durability = Durability::kNone, .base_index = base_index};
    return Store::open(path(), options, default_backends());
  }
  StoreCheck check() const { return check_store(path(), default_backends()); }
  std::string digest() const { return digest_of(open()); }
  static std::string digest_of(const Store& store) { return plait::digest(store).to_string(); }
  /// Changes a byte of the first page of the array that begins after `pages` pages of 4096 bytes.
  void damage(std::uint64_t offset) const {
    overwrite_byte(index(), offset, file_bytes(index())[offset] ^ std::byte{4});
  }

 private:
  TemporaryDirectory directory_{Medium::kMemory};
};

}  // namespace

TEST_CASE("StoreIndex_IsMadeForLargeMeshesOrWhenAskedFor") {
  const IndexedMesh large = torus_grid(128, 64), small = torus_grid(128, 63);
  REQUIRE(large.faces.size() == 1u << 14);
  CHECK(Made("pread", {}, large).has_index());
  CHECK_FALSE(Made("pread", {}, small).has_index());
  CHECK_FALSE(Made("pread", false, large).has_index());
  CHECK(Made("pread", true, small).has_index());
  CHECK(Made("pread", true, tetrahedron()).check().damaged.empty());
}

TEST_CASE("StoreIndex_OpensToTheSameStore_AndReadsOnlyWhatIsAskedFor") {
  for (const std::string& backend : durable_backends()) {
    CAPTURE(backend);
    const IndexedMesh mesh = side_by_side({torus_grid(120, 120), random_sheet(4, 60)});
    const Made with(backend, true, mesh), without(backend, false, mesh);
    CHECK(with.digest() == without.digest());
    const BaseReads reads;
    const Store store = with.open();
    CHECK(reads.mesh() == 0);
    const std::uint64_t size = std::filesystem::file_size(with.index());
    // Filters of compressed levels may look at all of the mesh.
    const bool is_compressed = backend == "compressed";
    CHECK((is_compressed || reads.index() < size / 8));
    const Store other = without.open();
    const Reader reader(store), expected(other);
    for (const FaceId face : {FaceId{0}, FaceId{3000}, FaceId{7205}}) {
      const PatchView patch = reader.read_patch(face, 1), right = expected.read_patch(face, 1);
      std::vector<std::byte> found(6 * 12), wanted(6 * 12);
      patch.records("position").copy_to(found);
      right.records("position").copy_to(wanted);
      CHECK(found == wanted);
    }
    CHECK((is_compressed || store.base().memory_bytes() < size / 2));
    CHECK(reads.index() < size + (64 << 10));
  }
}

TEST_CASE("StoreIndex_OfAStoreWithoutIt_ComesWithTheNextCommit") {
  const Made made("pread", false);
  const std::string digest = made.digest();
  {
    Store store = made.open(true);
    commit_anew(store);
  }
  CHECK_FALSE(made.has_index());  // the mesh is small, and nobody asks for it
  {
    Store store = made.open(true, true);
    CHECK_FALSE(made.has_index());
    commit_anew(store);
    CHECK(made.has_index());
  }
  CHECK(made.check().damaged.empty());
  CHECK(made.check().left_over.empty());
  CHECK(made.digest() == digest);
  // A writer of a store that has it changes nothing in it.
  const auto before = file_bytes(made.index());
  {
    Store store = made.open(true, false);
    commit_anew(store);
  }
  CHECK(file_bytes(made.index()) == before);
  CHECK(made.digest() == digest);
}

TEST_CASE("StoreIndex_Damaged_IsNamedAndMadeAgain") {
  const Made made("pread", true);
  const std::string digest = made.digest();
  const std::vector<std::byte> whole = file_bytes(made.index());
  for (const std::uint64_t offset : {std::uint64_t{3}, std::uint64_t{60}, std::uint64_t{5000},
                                     whole.size() / 2, whole.size() - 4097}) {
    CAPTURE(offset);
    made.damage(offset);
    const StoreCheck check = made.check();
    REQUIRE(check.damaged.size() == 1);
    CHECK(check.damaged[0].name == "base.index");
    CHECK(check.damaged[0].kind == StoreFile::kBaseIndex);
    RepairReport report = repair(made.path(), {.dry_run = true}, default_backends());
    CHECK(report.whole());
    CHECK(report.rebuilt_files.size() == 1);
    CHECK(file_bytes(made.index()) != whole);
    report = repair(made.path(), {}, default_backends());
    REQUIRE(report.rebuilt_files.size() == 1);
    CHECK(report.rebuilt_files[0].name == "base.index");
    CHECK(report.whole());
    CHECK(file_bytes(made.index()) == whole);
  }
  std::filesystem::resize_file(made.index(), whole.size() - 1);
  CHECK(names(error_of([&] { made.open(); }), {"base.index", "plait repair"}));
  CHECK(repair(made.path(), {}, default_backends()).whole());
  CHECK(made.digest() == digest);
  // A damaged base.mesh is found by who looks for it, and nothing is made of it.
  overwrite_byte(made.path() / "base.mesh", 40, std::byte{0xa5});
  CHECK(made.digest() == digest);
  const StoreCheck check = made.check();
  REQUIRE(check.damaged.size() == 1);
  CHECK(check.damaged[0].name == "base.mesh");
  CHECK_FALSE(repair(made.path(), {}, default_backends()).whole());
}

TEST_CASE("StoreIndex_OfALargeMesh_IsAddedByRepair") {
  const Made made("pread", false, torus_grid(128, 64));
  CHECK(repair(made.path(), {.dry_run = true}, default_backends()).rebuilt_files.size() == 1);
  CHECK_FALSE(made.has_index());
  const RepairReport report = repair(made.path(), {}, default_backends());
  REQUIRE(report.rebuilt_files.size() == 1);
  CHECK(report.rebuilt_files[0].name == "base.index");
  CHECK(made.has_index());
  CHECK(made.check().damaged.empty());
  CHECK(repair(made.path(), {}, default_backends()).rebuilt_files.empty());
}

TEST_CASE("StoreIndex_DamagedInOnePage_KeepsOthersReadable") {
  const Made made("pread", true);
  const std::uint64_t face_count = made.open().base().face_count();
  const std::vector<std::byte> whole = file_bytes(made.index());
  // The last page of the corners of faces, found by the numbers that it has.
  const Store store = made.open();
  const auto last = std::as_bytes(store.base().faces().subspan(face_count - 3));
  const auto at = std::ranges::search(whole, last).begin() - whole.begin();
  made.damage(static_cast<std::uint64_t>(at));
  const Store damaged = made.open();
  const Reader reader(damaged);
  CHECK_NOTHROW(reader.read_patch(5, 1));
  const auto code = [&](FaceId face) { return code_of([&] { reader.read_patch(face, 1); }); };
  CHECK(code(static_cast<FaceId>(face_count - 1)) == ErrorCode::kCorruption);
  CHECK(reader.prefetch(std::vector<FaceId>{static_cast<FaceId>(face_count - 1)}, 1) == 0);
  CHECK(code_of([&] { Made::digest_of(damaged); }) == ErrorCode::kCorruption);
  CHECK_NOTHROW(reader.read_patch(5, 1));
}

TEST_CASE("StoreIndex_ReadByManyThreads_IsTheSame") {
  const Made made("pread", true);
  const Store store = made.open();
  const BaseMesh right = BaseMesh(made.open().base());
  const Reader reader(store);
  std::atomic<int> wrong = 0;
  {
    std::vector<std::jthread> threads;
    for (std::uint32_t thread = 0; thread < 4; ++thread)
      threads.emplace_back([&, thread] {
        for (FaceId face = thread; face < store.base().face_count(); face += 5) {
          const PatchView patch = reader.read_patch(face, 1);
          if (store.base().arrays().mesh.faces[face] != right.faces()[face]) ++wrong;
          if (face % 1000 == thread && store.base().topology().edges.empty()) ++wrong;
        }
      });
  }
  CHECK(wrong == 0);
}

}  // namespace plait::test
