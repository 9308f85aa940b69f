// The transparent executor: at(level, i, j) is the right record of the store, wherever it is kept.
#include "plait/extend/patch.h"

#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <utility>

#include "engine/execution/numbered_store.h"
#include "plait/extend/in_core_mesh.h"
#include "plait/extend/store_access.h"
#include "plait/store_info.h"
#include "support/error_of.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

static_assert(PatchMesh<StorePatches<Wide>> && PatchMesh<InCoreMesh<Wide>>);

/// Points of a face, of the faces across its sides, and, for kRing, some of the faces across
/// these: all that a kernel with this reach may ask for.
std::vector<std::array<std::int64_t, 3>> points_in_reach(Reach reach) {
  std::vector<std::array<std::int64_t, 3>> points;
  for (std::int64_t j = 0; j <= kSize; ++j)
    for (std::int64_t i = 0; i + j <= kSize; ++i) points.push_back({kSize - i - j, i, j});
  if (reach == Reach::kOwn) return points;
  for (std::size_t x = 0; x < 3; ++x) {
    const auto add = [&](std::int64_t at_x, std::int64_t after) {
      std::array<std::int64_t, 3> k;
      k[x] = at_x;
      k[(x + 1) % 3] = after;
      k[(x + 2) % 3] = kSize - at_x - after;
      points.push_back(k);
    };
    for (std::int64_t depth = 1; depth <= kSize; ++depth) {
      for (std::int64_t after = depth; after <= kSize; ++after) add(-depth, after);
      if (reach != Reach::kRing || depth == 1 || depth == kSize) continue;
      add(-depth, kSize + 1);
      add(-depth, depth - 1);
    }
  }
  return points;
}

/// Bytes of the blocks that a face needs at once, the most over all faces.
std::uint64_t widest_face_bytes(Store& store) {
  const Topology mesh = store.base().topology();
  std::uint64_t most = 0;
  for (FaceId face = 0; face < store.base().face_count(); ++face) {
    std::set<std::pair<int, std::uint64_t>> blocks;
    for (int side = 0; side < 3; ++side) {
      const FaceSide beyond = mesh.across(FaceSide(face, side));
      for (const FaceId near : {face, beyond.exists() ? beyond.face() : face})
        for (const EdgeId edge : mesh.face_edges[near])
          for (int level = 1; level <= kLevels; ++level)
            blocks.emplace(level, StoreAccess::level_file(store, 0, level).geometry.block_of(edge));
    }
    most = std::max<std::uint64_t>(most, blocks.size() * 4096);
  }
  return most;
}

/// Reads every point in reach of every face and looks at it again when all of the face is read.
void check_all_points(Store& store, const Expected& expected, Reach reach,
                      std::uint64_t window_bytes) {
  StorePatches<Wide> patches(store, 0, window_bytes, reach);
  const int finest = store.base_level() + kLevels;
  patches.activate(finest, 1, 0);
  const auto points = points_in_reach(reach);
  bool exists_right = true, value_right = true, stays = true;
  std::uint64_t beyond_border = 0;
  for (FaceId face = 0; face < store.base().face_count(); ++face) {
    const auto patch = patches.patch(face);
    std::vector<std::pair<const Wide*, std::uint32_t>> seen;
    for (const auto& k : points) {
      const std::uint32_t vertex = expected.vertex({face, k});
      exists_right &= patch.exists(finest, k[1], k[2]) == (vertex != naive::kNone);
      if (vertex == naive::kNone) {
        ++beyond_border;
        continue;
      }
      seen.emplace_back(&patch.at(finest, k[1], k[2]), vertex);
      value_right &= seen.back().first->vertex == vertex;
    }
    std::size_t next = 0;
    for (const auto& k : points) {
      if (!patch.exists(finest, k[1], k[2])) continue;
      const auto& [record, vertex] = seen[next++];
      stays &= record == &patch.at(finest, k[1], k[2]) && record->vertex == vertex;
    }
  }
  CHECK(exists_right);
  CHECK(value_right);
  CHECK(stays);
  CHECK((beyond_border > 0) == (reach != Reach::kOwn && store.base().border_edge_count() > 0));
}

}  // namespace

TEST_CASE("PatchAt_EveryPointInReach_IsTheRecordOfItsVertex") {
  for (const IndexedMesh& mesh : {random_sphere(3, 80), random_sheet(5, 80), random_torus(7, 40),
                                  two_triangles(), octahedron(), two_components()})
    for (const Reach reach : {Reach::kOwn, Reach::kFaces, Reach::kRing}) {
      const BaseMesh base = BaseMesh::build(mesh);
      const OnDisk place("pread", base);
      Store store = place.open();
      check_all_points(store, place.expected, reach, 32 << 20);
    }
}

TEST_CASE("PatchAt_SmallestWindow_StaysValidWithinAPatch") {
  for (const std::string& backend : durable_backends())
    for (const IndexedMesh& mesh : {random_sphere(4, 150), random_sheet(6, 150)}) {
      INFO(backend);
      const BaseMesh base = BaseMesh::build(mesh);
      const OnDisk place(backend, base);
      std::uint64_t needed = 0;
      {
        Store store = place.open();
        needed = widest_face_bytes(store);
      }
      REQUIRE(needed > 64 << 10);
      Store store = place.open();
      leave_for_frames(store, needed);
      check_all_points(store, place.expected, Reach::kFaces, 0);
      CHECK(store.info().paging.peak_frame_bytes == needed);
      CHECK(store.info().paging.blocks_evicted > 100);

      Store smaller = place.open();
      leave_for_frames(smaller, needed - 1);
      StorePatches<Wide> patches(smaller, 0, 0);
      patches.activate(kLevels, 1, 0);
      const Error error = error_of([&] {
        for (FaceId face = 0; face < base.face_count(); ++face) patches.patch(face);
      });
      CHECK(error.code() == ErrorCode::kBudget);
    }
}

TEST_CASE("PatchAt_AmpleWindow_ReadsEveryBlockOnce") {
  const BaseMesh base = BaseMesh::build(random_sphere(4, 150));
  const OnDisk place("pread", base);
  Store store = place.open();
  check_all_points(store, place.expected, Reach::kFaces, 32 << 20);
  std::uint64_t blocks = 0;
  for (int level = 1; level <= kLevels; ++level)
    blocks += StoreAccess::level_file(store, 0, level).geometry.block_count();
  CHECK(store.info().paging.blocks_read == blocks);
  CHECK(store.info().paging.blocks_written == 0);
}

TEST_CASE("PatchAt_BaseLevelAboveZero_CountsLevelsFromTheGivenMesh") {
  constexpr int kBaseLevel = 2;
  const BaseMesh base = BaseMesh::build(random_sheet(5, 60));
  const OnDisk place("mmap", base, kBaseLevel);
  Store store = place.open();
  check_all_points(store, place.expected, Reach::kFaces, 32 << 20);

  // A patch is a face of the base mesh, whose grid at the base level are its corners.
  StorePatches<Wide> patches(store, 0, 32 << 20);
  patches.activate(kBaseLevel + 1, 1, 0);
  for (FaceId face = 0; face < base.face_count(); ++face) {
    const auto patch = patches.patch(face);
    CHECK(patch.size(kBaseLevel) == 1);
    CHECK(patch.size(kBaseLevel + 1) == 2);
    CHECK(patch.at(kBaseLevel, 0, 0).vertex == base.faces()[face][0]);
    CHECK(patch.at(kBaseLevel, 1, 0).vertex == base.faces()[face][1]);
    CHECK(patch.at(kBaseLevel + 1, 0, 2).vertex == base.faces()[face][2]);
    CHECK(patch.at(kBaseLevel + 1, 1, 1).vertex ==
          place.expected.vertex({face, {0, kSize / 2, kSize / 2}}));
  }
}

TEST_CASE("PatchAt_LevelOrPointThatIsNotThere_IsRefusedInWords") {
  constexpr int kBaseLevel = 2;
  const BaseMesh base = BaseMesh::build(two_triangles());
  const OnDisk place("pread", base, kBaseLevel);
  Store store = place.open();
  StorePatches<Wide> patches(store, 0, 32 << 20);
  patches.activate(kBaseLevel + 1, 1, 0);
  const auto patch = patches.patch(1);
  for (const int level : {-1, 0, kBaseLevel - 1, kBaseLevel + 2, 64}) {
    const Error error = error_of([&] { patch.at(level, 0, 0); });
    CHECK(error.code() == ErrorCode::kInvalidArgument);
    CHECK(names(error, {"face 1", fmt::format("level {}:", level), "2 to 3"}));
  }
  // The grid of a mesh that was not refined beforehand would have size 8.
  const Error far = error_of([&] { patch.at(kBaseLevel + 1, 8, 0); });
  CHECK(far.code() == ErrorCode::kInvalidArgument);
  CHECK(names(far, {"face 1", "level 3", "size 2", "(8, 0)", "base mesh is at level 2"}));
  int beyond = 0;
  for (const auto& [i, j] : {std::pair(-1, 1), std::pair(1, -1), std::pair(2, 1)})
    if (!patch.exists(kBaseLevel + 1, i, j)) {
      ++beyond;
      CHECK(error_of([&] { patch.at(kBaseLevel + 1, i, j); }).code() ==
            ErrorCode::kInvalidArgument);
    }
  CHECK(beyond == 2);
  CHECK(error_of([&] { patches.activate(kBaseLevel - 1, 1, 0); }).code() ==
        ErrorCode::kInvalidArgument);
}

TEST_CASE("PatchAt_CoarserLevel_IsTheSameRecord") {
  const BaseMesh base = BaseMesh::build(random_sheet(5, 60));
  const OnDisk place("pread", base);
  Store store = place.open();
  StorePatches<Wide> patches(store, 0, 32 << 20);
  patches.activate(kLevels, 1, 0);
  bool same = true, in_base = true;
  for (FaceId face = 0; face < base.face_count(); ++face) {
    const auto patch = patches.patch(face);
    CHECK(patch.face() == face);
    for (int level = 0; level < kLevels; ++level)
      for (std::int64_t j = 0; j <= 1 << level; ++j)
        for (std::int64_t i = 0; i + j <= 1 << level; ++i)
          same &= &patch.at(level, i, j) ==
                  &patch.at(kLevels, i << (kLevels - level), j << (kLevels - level));
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const FaceIndex at = corner_point(face, 0, static_cast<int>(corner));
      in_base &= &patch.at(0, at.i, at.j) ==
                 &std::as_const(store).base_records<Wide>(0)[base.faces()[face][corner]];
    }
  }
  CHECK(same);
  CHECK(in_base);
}

TEST_CASE("PatchAt_Writes_Persist") {
  for (const std::string& backend : durable_backends()) {
    INFO(backend);
    const BaseMesh base = BaseMesh::build(random_sheet(6, 150));
    const OnDisk place(backend, base);
    {
      Store store = place.open();
      const std::uint64_t budget = widest_face_bytes(store);
      store.close();
      store = place.open(64 << 20, true);
      leave_for_frames(store, budget);
      StorePatches<Wide> patches(store, 0, 0);
      patches.activate(kLevels, 2, kLevels);
      for (FaceId face = 0; face < base.face_count(); ++face) {
        const auto patch = patches.patch(face);
        for (std::int64_t j = 0; j <= kSize; ++j)
          for (std::int64_t i = 0; i + j <= kSize; ++i)
            if (((i | j) & (kSize / 2 - 1)) != 0) {  // born at level 2 or 3
              Wide& record = patch.at(kLevels, i, j);
              record.rest[0] = record.vertex + 1000;
              ++record.rest[1];  // how many faces it belongs to
            }
      }
      store.commit();
    }
    Store store = place.open();
    StorePatches<Wide> patches(store, 0, 32 << 20);
    patches.activate(kLevels, 1, 0);
    bool right = true;
    for (FaceId face = 0; face < base.face_count(); ++face) {
      const auto patch = patches.patch(face);
      for (std::int64_t j = 0; j <= kSize; ++j)
        for (std::int64_t i = 0; i + j <= kSize; ++i) {
          const Wide& record = patch.at(kLevels, i, j);
          right &= record.vertex == place.expected.vertex({face, {kSize - i - j, i, j}});
          const bool written = ((i | j) & (kSize / 2 - 1)) != 0;
          const int side = i + j == kSize ? 0 : i == 0 ? 1 : j == 0 ? 2 : -1;
          const bool shared = side >= 0 && !place.expected.has_border(face, side);
          right &= record.rest[0] == (written ? record.vertex + 1000 : 0);
          right &= record.rest[1] == (written ? (shared ? 2u : 1u) : 0u);
        }
    }
    CHECK(right);
  }
}

TEST_CASE("PatchSides_EveryFace_AreOwnedOnceAndBorderWhereNothingIsBeyond") {
  for (const NamedMesh& named : all_meshes()) {
    INFO(named.name);
    const BaseMesh base = BaseMesh::build(named.mesh);
    const Expected expected(base);
    StoreOptions options = sample_options("memory");
    Store store = Store::create({}, base, options, default_backends());
    store.add_attribute(schema_of<Wide>("vertex"));
    StorePatches<Wide> patches(store, 0, 0);
    patches.activate(0, 1, 0);
    InCoreMesh<Wide> arrays(base, 1);
    std::vector<int> owners(base.edge_count());
    for (FaceId face = 0; face < base.face_count(); ++face) {
      const auto patch = patches.patch(face);
      const auto in_core = arrays.patch(face);
      for (int side = 0; side < 3; ++side) {
        CHECK(patch.is_border(side) == expected.has_border(face, side));
        CHECK(in_core.is_border(side) == patch.is_border(side));
        CHECK(in_core.owns(side) == patch.owns(side));
        if (patch.owns(side)) ++owners[base.face_edges()[face][static_cast<std::size_t>(side)]];
      }
    }
    CHECK(std::ranges::all_of(owners, [](int count) { return count == 1; }));
  }
}

TEST_CASE("PatchActivate_LevelThatIsNotThere_IsRefused") {
  const BaseMesh base = BaseMesh::build(tetrahedron());
  const OnDisk place("pread", base);
  Store store = place.open();
  StorePatches<Wide> patches(store, 0, 0);
  for (const int level : {-1, kLevels + 1}) {
    const Error error = error_of([&] { patches.activate(level, 1, 0); });
    CHECK(error.code() == ErrorCode::kInvalidArgument);
    CHECK(names(error, {"'vertex'", "0 to 3"}));
  }
  CHECK(error_of([&] { StorePatches<float>(store, 0, 0); }).code() == ErrorCode::kInvalidArgument);
}

TEST_CASE("PatchActivate_WritableLevelOfAStoreOpenedForReading_IsRefused") {
  const BaseMesh base = BaseMesh::build(tetrahedron());
  for (const std::string& backend : durable_backends()) {
    const OnDisk place(backend, base);
    Store store = place.open();
    StorePatches<Wide> patches(store, 0, 0);
    const Error error = error_of([&] { patches.activate(kLevels, 2, 2); });
    CHECK(error.code() == ErrorCode::kBadState);
    CHECK(names(error, {"level 2", "'vertex'", place.path.string()}));
  }
}

TEST_CASE("PatchActivate_AgainAfterANewLevel_SeesIt") {
  const BaseMesh base = BaseMesh::build(random_sheet(5, 60));
  StoreOptions options = sample_options("memory");
  options.budget_bytes = 64 << 20;
  Store store = Store::create({}, base, options, default_backends());
  const AttributeId id = store.add_attribute(schema_of<Wide>("vertex"));
  StorePatches<Wide> patches(store, id, 32 << 20);
  for (int level = 1; level <= kLevels; ++level) {
    store.add_level(id);
    patches.activate(level, level, level);
    for (FaceId face = 0; face < base.face_count(); ++face)
      for (std::int64_t j = 0; j <= 1 << level; ++j)
        for (std::int64_t i = 0; i + j <= 1 << level; ++i)
          if (((i | j) & 1) != 0) ++patches.patch(face).at(level, i, j).rest[level];
  }
  patches.activate(kLevels, 1, 0);
  bool right = true;
  for (FaceId face = 0; face < base.face_count(); ++face)
    for (std::int64_t j = 1; j < kSize - 1; ++j)
      for (std::int64_t i = 1; i + j < kSize; ++i) {
        const int born = kLevels - std::countr_zero(static_cast<std::uint64_t>(i | j));
        const Wide& record = patches.patch(face).at(kLevels, i, j);
        for (int level = 1; level <= kLevels; ++level)
          right &= record.rest[level] == (level == born ? 1u : 0u);
      }
  CHECK(right);
}
