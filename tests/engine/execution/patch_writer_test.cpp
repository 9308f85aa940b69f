// PatchWriter: patches in any order, from any thread, become the levels that their records came
// from; a vertex gets its owner's record; what nobody wrote is named.
#include "plait/patch_writer.h"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <functional>
#include <numeric>
#include <optional>
#include <random>
#include <thread>

#include "engine/store/sample_store.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/store_access.h"
#include "plait/reader.h"
#include "plait/registry.h"
#include "plait/store_info.h"
#include "support/error_of.h"
#include "support/sanitized.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

constexpr int kFinest = 3;

/// The grid of a patch in row order, made of the sample's slots without any code of the executors.
std::vector<std::byte> sample_patch(const Store& store, const AttributeSchema& schema, FaceId face,
                                    int level) {
  const Topology mesh = store.base().topology();
  const int refinements = level - store.base_level();
  const std::int64_t size = std::int64_t{1} << refinements;
  const std::size_t bytes = schema.record_bytes();
  std::vector<std::byte> records;
  for (std::int64_t j = 0; j <= size; ++j)
    for (std::int64_t i = 0; i + j <= size; ++i) {
      std::vector<std::byte> record;
      if (is_corner(refinements, i, j)) {
        const VertexId vertex = mesh.faces[face][static_cast<std::size_t>(corner_of(i, j))];
        record = sample_slot(schema, 0, vertex, vertex, bytes);
      } else {
        const EdgeIndex at = edge_index(mesh, {face, refinements, i, j});
        const Edge& edge = mesh.edges[at.edge];
        const SlotShape shape = edge.is_border() ? SlotShape::kHalf : SlotShape::kWhole;
        const std::vector<std::byte> slot =
            sample_slot(schema, at.level + store.base_level(), edge.start, edge.end,
                        slot_records(at.level, shape) * bytes);
        const auto place =
            static_cast<std::size_t>(slot_position(at.level, shape, at.row, at.column));
        record.assign(slot.begin() + static_cast<std::ptrdiff_t>(place * bytes),
                      slot.begin() + static_cast<std::ptrdiff_t>((place + 1) * bytes));
      }
      records.insert(records.end(), record.begin(), record.end());
    }
  return records;
}

std::vector<FaceId> faces_in_any_order(const Store& store, unsigned seed) {
  std::vector<FaceId> faces(store.base().face_count());
  std::iota(faces.begin(), faces.end(), FaceId{0});
  std::shuffle(faces.begin(), faces.end(), std::mt19937(seed));
  return faces;
}

Store empty_store(const std::filesystem::path& path, const std::string& backend, BaseMesh base,
                  const std::vector<AttributeSchema>& schemas, int base_level = 0) {
  Store store = Store::create(path, std::move(base), sample_options(backend), default_backends(),
                              {.base_level = base_level});
  for (const AttributeSchema& schema : schemas) store.add_attribute(schema, base_level + kFinest);
  return store;
}

/// A store in memory with attribute "height".
struct Heights {
  explicit Heights(IndexedMesh mesh = octahedron())
      : store(empty_store({}, "memory", BaseMesh::build(std::move(mesh)),
                          {schema_of<float>("height")})) {}

  static std::vector<float> patch(float value, int level = kFinest) {
    return std::vector<float>(patch_vertex_count(std::int64_t{1} << level), value);
  }
  void write_all(PatchWriter& writer, std::optional<FaceId> but = {}) const {
    for (FaceId face = 0; face < store.base().face_count(); ++face)
      if (face != but) writer.write_patch<float>("height", face, kFinest, patch(7));
  }
  float at(FaceId face, std::int64_t i, std::int64_t j) const {
    return Reader(store).read_patch(face, kFinest).attribute<float>("height").at(i, j);
  }

  Store store;
};

/// The message of the kInvalidArgument that a call must throw.
Error refused(const std::function<void()>& call, ErrorCode code = ErrorCode::kInvalidArgument) {
  const Error error = error_of(call);
  CHECK(error.code() == code);
  return error;
}

}  // namespace

TEST_CASE("PatchWriter_PatchesInAnyOrder_FillEveryLevelOfEveryAttribute") {
  std::vector<std::string> backends = durable_backends();
  backends.emplace_back("memory");
  const auto backend = GENERATE_COPY(from_range(backends));
  const auto base_level = GENERATE(0, 2);
  const auto level_by_level = GENERATE(false, true);
  const auto compare = unless_sanitized(true, false) ? GENERATE(false, true) : level_by_level;
  const bool in_memory = backend == "memory";
  unsigned seed = 1;
  for (const IndexedMesh& mesh : {torus_grid(3, 4), sheet(3, 3), two_faces_back_to_back(),
                                  two_components(), single_triangle()}) {
    INFO(backend << ", mesh " << seed);
    const TemporaryDirectory directory(Medium::kMemory);
    const std::filesystem::path path = in_memory ? "" : directory.path() / "s.plait";
    Store store = empty_store(path, backend, BaseMesh::build(mesh), sample_schemas(), base_level);
    if (!in_memory) leave_for_frames(store, 96 << 10);
    PatchWriter writer(store, {.compare = compare});
    for (const FaceId face : faces_in_any_order(store, seed++))
      for (const AttributeSchema& schema : sample_schemas())
        for (int level = level_by_level ? base_level : base_level + kFinest;
             level <= base_level + kFinest; ++level) {
          const std::vector<std::byte> records = sample_patch(store, schema, face, level);
          if (level_by_level)
            writer.write_level_of_bytes(schema.name, face, level, records);
          else
            writer.write_patch_of_bytes(schema.name, face, level, records);
        }
    writer.finish();
    if (!in_memory) {
      CHECK(store.info().paging.peak_frame_bytes <= 96 << 10);
      store.commit();
      store.close();
      store = Store::open(path, {.writable = true}, default_backends());
    }
    for (AttributeId id = 0; id < store.attributes().size(); ++id) CHECK(holds_sample(store, id));
  }
}

TEST_CASE("PatchWriter_ManyThreads_FillTheSameStore") {
  const auto backend = GENERATE(as<std::string>(), "pread", "compressed", "memory");
  const auto compare = GENERATE(false, true);
  const TemporaryDirectory directory(Medium::kMemory);
  const AttributeSchema schema = schema_of<Vector3<float>>("position");
  Store store = empty_store(backend == "memory" ? "" : directory.path() / "s.plait", backend,
                            BaseMesh::build(random_sheet(5, 200)), {schema});
  if (backend != "memory") leave_for_frames(store, 160 << 10);
  const std::vector<FaceId> faces = faces_in_any_order(store, 3);
  std::vector<std::vector<std::byte>> patches;
  for (const FaceId face : faces) patches.push_back(sample_patch(store, schema, face, kFinest));
  PatchWriter writer(store, {.compare = compare});
  std::atomic<std::size_t> next = 0;
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 4; ++i)
      threads.emplace_back([&] {
        for (std::size_t at = next++; at < faces.size(); at = next++)
          writer.write_patch_of_bytes("position", faces[at], kFinest, patches[at]);
      });
  }
  writer.finish();
  CHECK(holds_sample(store, 0));
}

TEST_CASE("PatchWriter_FacesInLayoutOrder_WriteEachBlockOnceAndReadNone") {
  const auto backend = GENERATE(as<std::string>(), "pread", "compressed");
  const auto descending = GENERATE(false, true);
  const TemporaryDirectory directory(Medium::kMemory);
  const AttributeSchema schema = schema_of<Vector3<float>>("position");
  Store store = empty_store(directory.path() / "s.plait", backend,
                            BaseMesh::build(torus_grid(8, 8)), {schema});
  PatchWriter writer(store);
  const auto faces = static_cast<FaceId>(store.base().face_count());
  for (FaceId at = 0; at < faces; ++at) {
    const FaceId face = descending ? faces - 1 - at : at;
    writer.write_patch_of_bytes("position", face, kFinest,
                                sample_patch(store, schema, face, kFinest));
  }
  writer.finish();
  store.commit();
  std::uint64_t blocks = 0;
  for (int level = 1; level <= kFinest; ++level)
    blocks += StoreAccess::level_file(store, 0, level).geometry.block_count();
  CHECK(writer.statistics().blocks_read == 0);
  CHECK(store.info().paging.blocks_written == blocks);
  CHECK(holds_sample(store, 0));
}

TEST_CASE("PatchWriter_FacesThatDisagree_LeaveTheOwnersRecord") {
  const auto own_first = GENERATE(false, true);
  Heights heights;
  const Topology mesh = heights.store.base().topology();
  const FaceId own = mesh.edges[0].own.face(), other = mesh.edges[0].other.face();
  PatchWriter writer(heights.store);
  heights.write_all(writer);
  for (const bool turn : {own_first, !own_first})
    writer.write_patch<float>("height", turn ? own : other, kFinest, Heights::patch(turn ? 1 : 2));
  writer.finish();
  const int side = mesh.edges[0].other.side();
  const FaceIndex on_edge = from_side(other, {side, 1, 0, 0});
  CHECK(heights.at(other, on_edge.i << 2, on_edge.j << 2) == 1);
  CHECK(heights.at(other, 2, 2) == 2);
  for (VertexId vertex = 0; vertex < 6; ++vertex) {
    const FaceId owner = mesh.vertex_corners[vertex].face();
    CHECK(std::as_const(heights.store).base_records<float>(0)[vertex] == (owner == own     ? 1
                                                                          : owner == other ? 2
                                                                                           : 7));
  }
}

TEST_CASE("PatchWriter_ComparesRecords_RefusesTwoDifferentOnes") {
  Heights heights;
  const Topology mesh = heights.store.base().topology();
  const FaceId own = mesh.edges[0].own.face(), other = mesh.edges[0].other.face();
  PatchWriter writer(heights.store, {.compare = true});
  const FaceIndex on_edge = from_side(other, {mesh.edges[0].other.side(), 2, 1, 0});
  std::vector<float> records = Heights::patch(7);
  records[static_cast<std::size_t>(patch_vertex(8, on_edge.i * 2, on_edge.j * 2))] = 7.5f;

  writer.write_patch<float>("height", own, kFinest, Heights::patch(7));
  const Error on_side =
      refused([&] { writer.write_patch<float>("height", other, kFinest, records); });
  CHECK(names(on_side,
              {"face " + std::to_string(other) + " ", "'height'", "level 3",
               "(" + std::to_string(on_edge.i * 2) + ", " + std::to_string(on_edge.j * 2) + ")",
               " is 7.5, ", "face " + std::to_string(own), "written 7 "}));
  CHECK(names(refused([&] { writer.finish(); }, ErrorCode::kBadState), {"was not written"}));

  records = Heights::patch(7);
  const VertexId shared = mesh.edges[0].start;
  const std::array<VertexId, 3>& corners = mesh.faces[other];
  const int corner = static_cast<int>(std::ranges::find(corners, shared) - corners.begin());
  const FaceIndex at = corner_point(other, kFinest, corner);
  records[static_cast<std::size_t>(patch_vertex(8, at.i, at.j))] = -1;
  const Error at_corner =
      refused([&] { writer.write_patch<float>("height", other, kFinest, records); });
  CHECK(names(at_corner, {"(" + std::to_string(at.i) + ", " + std::to_string(at.j) + ")", " is -1,",
                          "face " + std::to_string(own), "written 7 "}));

  heights.write_all(writer);
  writer.finish();
  CHECK(heights.at(other, at.i, at.j) == 7);
}

TEST_CASE("PatchWriter_RecordsOfSeveralNumbers_AreNamedExactly") {
  Store store = empty_store({}, "memory", BaseMesh::build(two_triangles()),
                            {schema_of<Vector3<double>>("point"), schema_of<std::uint8_t>("kind")});
  PatchWriter writer(store, {.compare = true});
  const auto points = [](double x) { return std::vector<Vector3<double>>(45, {x, 0.1, -2}); };
  writer.write_patch<Vector3<double>>("point", 0, kFinest, points(1));
  CHECK(names(refused([&] {
                writer.write_patch<Vector3<double>>("point", 1, kFinest, points(1 + 0x1p-52));
              }),
              {"(1.0000000000000002, 0.1, -2)", "(1, 0.1, -2)"}));
  writer.write_patch<std::uint8_t>("kind", 0, kFinest, std::vector<std::uint8_t>(45, 3));
  CHECK(names(refused([&] {
                writer.write_patch<std::uint8_t>("kind", 1, kFinest,
                                                 std::vector<std::uint8_t>(45, 200));
              }),
              {"is 200,", "written 3 "}));
}

TEST_CASE("PatchWriter_MissingPatch_IsNamedByFinishCommitAndReader") {
  Heights heights;
  {
    PatchWriter writer(heights.store);
    heights.write_all(writer, FaceId{5});
    writer.write_level<float>("height", 5, 2, Heights::patch(1, 2));
    CHECK(names(refused([&] { writer.finish(); }, ErrorCode::kBadState),
                {"'height'", "face 5", "1 of 8"}));
    CHECK(names(refused([&] { heights.store.commit(); }, ErrorCode::kBadState), {"under way"}));
  }
  CHECK(names(refused([&] { heights.store.commit(); }, ErrorCode::kBadState),
              {"level 0", "'height'", "face 5"}));
  const Reader reader(heights.store);
  CHECK(names(refused([&] { reader.read_patch(0, kFinest); }, ErrorCode::kBadState), {"face 5"}));
}

TEST_CASE("PatchWriter_WrittenAgain_EndsAnUnfinishedLevel") {
  Heights heights;
  { PatchWriter left(heights.store); }
  CHECK(error_of([&] { heights.store.commit(); }).code() == ErrorCode::kBadState);
  PatchWriter writer(heights.store);
  heights.write_all(writer, FaceId{5});
  CHECK(error_of([&] { writer.finish(); }).code() == ErrorCode::kBadState);
  heights.write_all(writer);
  writer.finish();
  CHECK(names(refused([&] { writer.finish(); }, ErrorCode::kBadState), {"has finished"}));
  heights.store.commit();
  CHECK(heights.at(5, 3, 3) == 7);
  CHECK(names(refused([&] { heights.write_all(writer); }, ErrorCode::kBadState), {"finished"}));
  heights.store.close();  // a writer that has finished holds nothing of the store
}

TEST_CASE("PatchWriter_LevelAfterLevel_ReadsTheCoarserOneBetween") {
  Heights heights;
  for (int level = 0; level <= kFinest; ++level) {
    PatchWriter writer(heights.store, {.first_level = level, .last_level = level});
    for (FaceId face = 0; face < 8; ++face) {
      std::vector<float> records = Heights::patch(float(level), level);
      writer.write_level<float>("height", face, level, records);
      CHECK_THROWS_AS(
          writer.write_patch<float>("height", face, level + 1, Heights::patch(0, level + 1)),
          Error);
    }
    writer.finish();
    const PatchView patch = Reader(heights.store).read_patch(3, level);
    const auto view = patch.attribute<float>("height");
    CHECK(view.at(0, 0) == 0);
    CHECK(view.at(view.size() > 1 ? 1 : 0, 0) == float(level));
  }
}

TEST_CASE("PatchWriter_CommittedAttribute_IsAsBeforeAfterRollBack") {
  const TemporaryDirectory directory(Medium::kMemory);
  const AttributeSchema schema = sample_schemas()[0];
  Store store = Store::create(directory.path() / "s.plait", BaseMesh::build(torus_grid(3, 4)),
                              sample_options("pread"), default_backends(), {.scheme = "loop"});
  add_sample(store, schema, kFinest);
  store.commit();
  const auto write = [&](FaceId faces) {
    PatchWriter writer(store);
    for (FaceId face = 0; face < faces; ++face)
      writer.write_patch<Vector3<float>>("position", face, kFinest,
                                         std::vector<Vector3<float>>(45, {1, 2, 3}));
    if (faces == store.base().face_count()) writer.finish();
  };
  write(7);
  CHECK(store.provenance().scheme.empty());
  store.roll_back();
  CHECK(holds_sample(store, 0));
  CHECK(store.provenance().scheme == "loop");
  write(static_cast<FaceId>(store.base().face_count()));
  store.commit();
  const Store reading = Store::open(directory.path() / "s.plait", {}, default_backends());
  CHECK(Reader(reading).read_patch(2, 3).attribute<Vector3<float>>("position").at(1, 1) ==
        Vector3<float>{1, 2, 3});
}

TEST_CASE("PatchWriter_WhatDoesNotFit_IsRefusedInWords") {
  Heights heights;
  heights.store.add_attribute(schema_of<float>("short"), 1);
  {
    PatchWriter writer(heights.store, {.attributes = {"height"}});
    const std::vector<float> records = Heights::patch(0);
    CHECK(names(refused([&] { writer.write_patch<float>("height", 8, 3, records); }),
                {"face 8", "below 8"}));
    CHECK(names(refused([&] { writer.write_patch<float>("height", 0, 4, records); }),
                {"level 4", "0 to 3"}));
    CHECK(
        names(refused([&] { writer.write_patch<float>("height", 0, -1, records); }), {"level -1"}));
    CHECK(names(refused([&] { writer.write_patch<float>("height", 0, 2, records); }),
                {"15 records", "180 bytes"}));
    CHECK(names(refused([&] {
                  writer.write_patch<std::int32_t>("height", 0, 3, std::vector<std::int32_t>(45));
                }),
                {"float32 x 1", "int32 x 1"}));
    CHECK(names(refused([&] { writer.write_patch<float>("short", 0, 1, Heights::patch(0, 1)); },
                        ErrorCode::kNotFound),
                {"'short'"}));
    CHECK(refused([&] { const PatchWriter second(heights.store); }, ErrorCode::kBadState).what() !=
          std::string());
  }
  heights.store.roll_back();
  Heights other;
  other.store.add_attribute(schema_of<float>("short"), 1);
  CHECK(names(refused([&] { const PatchWriter writer(other.store, {.last_level = 2}); }),
              {"'short'", "0 to 1"}));
  CHECK(names(
      refused([&] { const PatchWriter writer(other.store, {.first_level = 2, .last_level = 1}); }),
      {"2 to 1"}));
  CHECK(names(refused([&] {
                const PatchWriter writer(other.store, {.attributes = {"short", "short"}});
              }),
              {"'short'", "twice"}));
  CHECK(refused([&] { const PatchWriter writer(other.store, {.attributes = {"none"}}); },
                ErrorCode::kNotFound)
            .what() != std::string());
  other.store.commit();  // refusals leave nothing unfinished
  {
    const Reader reader(other.store);
    CHECK(refused([&] { const PatchWriter writer(other.store); }, ErrorCode::kBusy).what() !=
          std::string());
  }
}

TEST_CASE("PatchWriter_PredictedLevels_AreEncodedByTheCommitAndThenKept") {
  const TemporaryDirectory directory(Medium::kMemory);
  Store store = Store::create(directory.path() / "s.plait", BaseMesh::build(octahedron()),
                              sample_options("compressed"), default_backends());
  const AttributeSchema schema = schema_of<Vector3<float>>("position");
  const AttributeId id = store.add_attribute(schema);
  store.set_pipeline(id, "hierarchy+shuffle,zstd:1");
  for (int level = 1; level <= kFinest; ++level) store.add_level(id);
  const auto patch = [&](FaceId face) { return sample_patch(store, schema, face, kFinest); };
  PatchWriter writer(store);
  for (FaceId face = 0; face < store.base().face_count(); ++face)
    writer.write_patch_of_bytes("position", face, kFinest, patch(face));
  writer.finish();
  store.commit();
  for (int level = 1; level <= kFinest; ++level)
    CHECK(StoreAccess::level_file(store, id, level).pipeline == "hierarchy+shuffle,zstd:1");
  for (FaceId face = 0; face < store.base().face_count(); ++face) {
    const Reader reader(store);
    const PatchView view = reader.read_patch(face, kFinest);
    const auto records = view.attribute<Vector3<float>>("position");
    std::vector<Vector3<float>> found;
    for (std::int64_t j = 0; j <= 1 << kFinest; ++j)
      for (std::int64_t i = 0; i + j <= 1 << kFinest; ++i) found.push_back(records.at(i, j));
    CHECK(std::ranges::equal(std::as_bytes(std::span(found)), patch(face)));
  }
  CHECK(refused([&] { const PatchWriter again(store); }, ErrorCode::kBadState).what() !=
        std::string());
}

TEST_CASE("PatchWriter_BudgetOfLessThanAPatch_IsRefusedWithTheFigures") {
  const TemporaryDirectory directory(Medium::kMemory);
  Store store = empty_store(directory.path() / "s.plait", "pread",
                            BaseMesh::build(torus_grid(8, 8)), {sample_schemas()[4]});
  leave_for_frames(store, 16 << 10);
  PatchWriter writer(store);
  const auto patch = sample_patch(store, sample_schemas()[4], 0, kFinest);
  CHECK(names(
      refused([&] { writer.write_patch_of_bytes("wide", 0, kFinest, patch); }, ErrorCode::kBudget),
      {"bytes of frames"}));
}
