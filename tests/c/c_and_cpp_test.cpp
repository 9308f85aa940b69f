// The C interface and the C++ interface read the same bytes from one store.
#include <atomic>
#include <catch2/catch.hpp>
#include <cstring>
#include <string>
#include <thread>
#include <vector>

#include "io/file_operations.h"
#include "plait.h"
#include "plait/digest.h"
#include "plait/layout.h"
#include "plait/reader.h"
#include "plait/registry.h"
#include "plait/store_info.h"
#include "plait/subdivide.h"
#include "plait/verify.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

constexpr int kLevel = 4;

/// The same store, made by C++ and by C.
void make_by_cpp(const std::filesystem::path& path, const IndexedMesh& mesh, int base_level) {
  BaseMesh base = BaseMesh::build(mesh);
  if (base_level > 0) base = rebase(base, base_level, Scheme());
  StoreOptions options;
  options.block_bytes = 4096;
  Store store = Store::create(path, lay_out(base, LayoutKind::kAutomatic), options,
                              default_backends(), {.base_level = base_level});
  add_base_positions(store);
  subdivide(store, {.levels = kLevel, .normals = true, .limit = true});
  store.commit();
}

void make_by_c(const std::filesystem::path& path, const IndexedMesh& mesh, int base_level) {
  plait_store_options options = PLAIT_STORE_OPTIONS_INIT;
  options.base_level = base_level;
  options.block_bytes = 4096;
  plait_store* store = nullptr;
  REQUIRE(plait_store_create(path.c_str(), &mesh.positions[0].x, mesh.positions.size(),
                             mesh.faces[0].data(), mesh.faces.size(), &options,
                             &store) == PLAIT_OK);
  plait_subdivide_options work = PLAIT_SUBDIVIDE_OPTIONS_INIT;
  work.levels = kLevel;
  work.normals = work.limit = 1;
  REQUIRE(plait_store_subdivide(store, &work) == PLAIT_OK);
  REQUIRE(plait_store_commit(store) == PLAIT_OK);
  REQUIRE(plait_store_close(store) == PLAIT_OK);
}

plait_store* opened(const std::filesystem::path& path) {
  plait_store* store = nullptr;
  REQUIRE(plait_store_open(path.c_str(), nullptr, &store) == PLAIT_OK);
  return store;
}

std::vector<Vector3<float>> copy_by_c(const plait_reader* reader, const char* name, FaceId face,
                                      int level) {
  plait_view* view = nullptr;
  REQUIRE(plait_reader_read_patch(reader, face, level, &view) == PLAIT_OK);
  plait_view_info info = PLAIT_VIEW_INFO_INIT;
  REQUIRE(plait_view_get_info(view, &info) == PLAIT_OK);
  std::vector<Vector3<float>> records(info.vertex_count);
  CHECK(plait_view_copy(view, name, records.data(), records.size() * sizeof(records[0])) ==
        PLAIT_OK);
  plait_view_release(view);
  return records;
}

template <class Record>
bool same_bytes(const std::vector<Record>& a, const std::vector<Record>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Record)) == 0;
}

}  // namespace

TEST_CASE("CInterface_StoreMadeByC_IsTheStoreMadeByCpp") {
  const TemporaryDirectory directory;
  const int base_level = GENERATE(0, 1);
  const IndexedMesh mesh = sheet(4, 3);
  make_by_cpp(directory.path() / "cpp", mesh, base_level);
  make_by_c(directory.path() / "c", mesh, base_level);
  Store cpp = Store::open(directory.path() / "cpp", {}, default_backends());
  plait_store* const c = opened(directory.path() / "c");
  char digits[PLAIT_DIGEST_BYTES];
  REQUIRE(plait_store_digest(c, PLAIT_ALL_LEVELS, 2, nullptr, nullptr, digits) == PLAIT_OK);
  CHECK(digits == digest(cpp).to_string());
  REQUIRE(plait_store_digest(c, kLevel, 1, nullptr, nullptr, digits) == PLAIT_OK);
  CHECK(digits == digest(cpp, {.level = kLevel}).to_string());

  plait_verify_report report = PLAIT_VERIFY_REPORT_INIT;
  REQUIRE(plait_store_verify(c, nullptr, nullptr, nullptr, &report) == PLAIT_OK);
  const VerifyReport expected = verify(cpp);
  CHECK(report.blocks == expected.blocks);
  CHECK(report.bytes == expected.bytes);
  CHECK(report.damaged_count == 0);

  plait_store_info info = PLAIT_STORE_INFO_INIT;
  REQUIRE(plait_store_get_info(c, &info) == PLAIT_OK);
  CHECK(info.path == (directory.path() / "c").native());
  CHECK(info.backend == cpp.options().backend);
  CHECK(info.layout == cpp.provenance().layout);
  CHECK(info.scheme == std::string("loop"));
  CHECK(info.limit == 1);
  CHECK(info.sequence == cpp.sequence());
  CHECK(info.stored_bytes == cpp.info().stored_bytes);
  CHECK(info.face_count == cpp.base().face_count());
  CHECK(info.border_edge_count == cpp.base().border_edge_count());
  CHECK(info.attribute_count == cpp.attributes().size());
  CHECK(info.base_level == base_level);
  CHECK(info.finest_level == kLevel);
  CHECK(plait_store_close(c) == PLAIT_OK);
}

TEST_CASE("CInterface_StoreOpenedWithoutDurability_SyncsNothing") {
  class Syncs final : public FileOperationHook {
   public:
    Syncs() { set_file_operation_hook(this); }
    ~Syncs() { set_file_operation_hook(nullptr); }
    Verdict before(const FileOperation& operation) noexcept override {
      count += operation.kind == FileOperation::Kind::kSync ? 1 : 0;
      return {};
    }
    void after(const FileOperation&) noexcept override {}
    std::atomic<int> count = 0;
  };
  const TemporaryDirectory directory;
  make_by_cpp(directory.path() / "s", sheet(4, 3), 0);
  for (const bool durable : {false, true}) {
    const Syncs syncs;
    plait_open_options options = PLAIT_OPEN_OPTIONS_INIT;
    options.writable = 1;
    options.durability = durable ? PLAIT_DURABILITY_COMMIT : PLAIT_DURABILITY_NONE;
    plait_store* store = nullptr;
    REQUIRE(plait_store_open((directory.path() / "s").c_str(), &options, &store) == PLAIT_OK);
    REQUIRE(plait_store_add_attribute(store, durable ? "b" : "a", PLAIT_FLOAT32, 1, 0) == PLAIT_OK);
    REQUIRE(plait_store_commit(store) == PLAIT_OK);
    REQUIRE(plait_store_close(store) == PLAIT_OK);
    CHECK((syncs.count > 0) == durable);
  }
}

TEST_CASE("CInterface_PatchesAndVertices_AreThoseOfTheCppReader") {
  const TemporaryDirectory directory;
  const int base_level = GENERATE(0, 1);
  const auto path = directory.path() / "store";
  make_by_cpp(path, sheet(4, 3), base_level);
  const Store store = Store::open(path, {}, default_backends());
  const Reader reader(store);
  plait_store* const c_store = opened(path);
  plait_reader* c_reader = nullptr;
  REQUIRE(plait_reader_open(c_store, nullptr, &c_reader) == PLAIT_OK);
  for (const char* name : {"position", "normal"})
    for (int level = base_level; level <= kLevel; ++level) {
      for (FaceId face = 0; face < store.base().face_count(); ++face) {
        const PatchView patch = reader.read_patch(face, level);
        std::vector<Vector3<float>> records(patch_vertex_count(patch.size()));
        patch.attribute<Vector3<float>>(name).copy_to(records);
        CHECK(same_bytes(records, copy_by_c(c_reader, name, face, level)));
      }
      std::uint64_t count = 0;
      REQUIRE(plait_reader_vertex_count(c_reader, level, &count) == PLAIT_OK);
      REQUIRE(count == reader.vertex_count(level));
      std::vector<Vector3<float>> by_c(count), by_cpp(count);
      CHECK(plait_reader_read_vertices(c_reader, name, level, 0, count, by_c.data(),
                                       count * sizeof(by_c[0])) == PLAIT_OK);
      reader.for_each_block<Vector3<float>>(
          name, level, 0, count, [&](std::uint64_t first, std::span<const Vector3<float>> block) {
            std::ranges::copy(block, by_cpp.begin() + static_cast<std::ptrdiff_t>(first));
          });
      CHECK(same_bytes(by_c, by_cpp));
    }
  plait_reader_close(c_reader);
  CHECK(plait_store_close(c_store) == PLAIT_OK);
}

TEST_CASE("CInterface_SeveralThreads_ReadOneReaderAndKeepTheirOwnMessages") {
  const TemporaryDirectory directory;
  const auto path = directory.path() / "store";
  make_by_cpp(path, torus_grid(4, 4), 0);
  plait_store* const store = opened(path);
  plait_reader* reader = nullptr;
  REQUIRE(plait_reader_open(store, nullptr, &reader) == PLAIT_OK);
  const std::vector<Vector3<float>> expected = copy_by_c(reader, "position", 7, kLevel);
  std::atomic<int> wrong = 0;
  std::vector<std::thread> threads;
  for (std::uint32_t number = 0; number < 4; ++number)
    threads.emplace_back([&, number] {
      for (int turn = 0; turn < 100; ++turn) {
        plait_view* view = nullptr;
        const std::uint32_t face = 1000 + number;
        wrong += plait_reader_read_patch(reader, face, kLevel, &view) == PLAIT_OK;
        wrong += std::string_view(plait_error_message()).find(std::to_string(face)) ==
                 std::string_view::npos;
        std::vector<Vector3<float>> records(expected.size());
        wrong += plait_reader_read_patch(reader, 7, kLevel, &view) != PLAIT_OK;
        wrong += plait_view_copy(view, "position", records.data(),
                                 records.size() * sizeof(records[0])) != PLAIT_OK;
        wrong += !same_bytes(records, expected);
        plait_view_release(view);
      }
    });
  for (std::thread& thread : threads) thread.join();
  CHECK(wrong == 0);
  plait_reader_close(reader);
  CHECK(plait_store_close(store) == PLAIT_OK);
}

TEST_CASE("CInterface_PatchesWrittenByC_AreReadByCpp") {
  const TemporaryDirectory directory(Medium::kMemory);
  const std::filesystem::path path = directory.path() / "s.plait";
  make_by_c(path, octahedron(), 0);
  plait_open_options open = PLAIT_OPEN_OPTIONS_INIT;
  open.writable = 1;
  plait_store* store = nullptr;
  REQUIRE(plait_store_open(path.c_str(), &open, &store) == PLAIT_OK);
  REQUIRE(plait_store_add_attribute(store, "age", PLAIT_UINT32, 1, 2) == PLAIT_OK);
  plait_patch_writer_options options = PLAIT_PATCH_WRITER_OPTIONS_INIT;
  const char* const names[] = {"age"};
  options.attributes = names;
  options.attribute_count = 1;
  options.compare = 1;
  plait_patch_writer* writer = nullptr;
  REQUIRE(plait_patch_writer_open(store, &options, &writer) == PLAIT_OK);
  const std::vector<std::uint32_t> records(15, 21), others(15, 22);
  const auto write = [&](FaceId face, const std::vector<std::uint32_t>& from, int level) {
    return plait_patch_writer_write_patch(writer, "age", face, level, from.data(),
                                          from.size() * sizeof(from[0]));
  };
  for (FaceId face = 0; face < 8; ++face) {
    CHECK(plait_patch_writer_finish(writer) == PLAIT_ERROR_BAD_STATE);
    if (face > 0) CHECK(write(face, others, 2) == PLAIT_ERROR_INVALID_ARGUMENT);
    CHECK(write(face, records, 2) == PLAIT_OK);
  }
  CHECK(plait_patch_writer_write_level(writer, "age", 3, 1, records.data(), 24) == PLAIT_OK);
  CHECK(write(0, records, 3) == PLAIT_ERROR_INVALID_ARGUMENT);
  CHECK(plait_store_commit(store) == PLAIT_ERROR_BAD_STATE);
  CHECK(plait_patch_writer_finish(writer) == PLAIT_OK);
  plait_paging_statistics statistics = PLAIT_PAGING_STATISTICS_INIT;
  CHECK(plait_patch_writer_get_statistics(writer, &statistics) == PLAIT_OK);
  CHECK(statistics.blocks_read == 0);
  plait_patch_writer_close(writer);
  plait_patch_writer_close(nullptr);
  REQUIRE(plait_store_commit(store) == PLAIT_OK);
  REQUIRE(plait_store_close(store) == PLAIT_OK);
  const Store read = Store::open(path, {}, default_backends());
  const Reader reader(read, {.attributes = {"age"}});
  for (FaceId face = 0; face < 8; ++face)
    CHECK(reader.read_patch(face, 2).attribute<std::uint32_t>("age").at(1, 2) == 21);
}
