// The fused executor against sweep where patches, fans and groups of patches are unusual.
#include <fmt/format.h>

#include <catch2/catch.hpp>

#include "kernels/run_variant.h"
#include "plait/error.h"
#include "support/sanitized.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

Variant fused_on(int threads) {
  Variant variant;
  variant.executor = ExecutorKind::kFused;
  variant.threads = threads;
  return variant;
}

/// Digests of everything that a scheme can make of a mesh, by sweep and by fused.
void check_all_results(const IndexedMesh& mesh, int levels, int threads = 2) {
  const BaseMesh base = BaseMesh::build(mesh);
  struct Results {
    Scheme scheme;
    bool normals, limit, double_precision;
  };
  for (const auto& [scheme, normals, limit, double_precision] :
       {Results{Scheme::kLoop, false, false, false}, Results{Scheme::kLoop, true, false, true},
        Results{Scheme::kLoop, false, true, false}, Results{Scheme::kLoop, true, true, false},
        Results{Scheme::kLoop, true, true, true}, Results{Scheme::kMidpoint, false, false, false},
        Results{Scheme::kMidpoint, true, false, true},
        Results{Scheme::kButterfly, true, false, false},
        Results{Scheme::kButterfly, true, false, true}}) {
    const SubdivideOptions what{
        .scheme = scheme, .levels = levels, .normals = normals, .limit = limit};
    Variant sweep, fused = fused_on(threads);
    sweep.double_precision = fused.double_precision = double_precision;
    INFO(fmt::format("{} to level {}, normals {}, limit {}, double {}, threads {}",
                     to_string(scheme), levels, normals, limit, double_precision, threads));
    CHECK(run(base, what, fused).digest == run(base, what, sweep).digest);
  }
}

}  // namespace

TEST_CASE("FusedDigest_AllSmallMeshes_IsThatOfSweep") {
  for (const auto& [name, mesh] : all_meshes())
    for (int level = unless_sanitized(1, 3); level <= 3; level += 2) {
      INFO(name);
      check_all_results(mesh, level);
    }
}

TEST_CASE("FusedDigest_FewerFacesThanLanes_IsThatOfSweep") {
  for (const IndexedMesh& mesh :
       {single_triangle(), two_triangles(), tetrahedron(), closed_fan(3), open_fan(7), sheet(3, 1)})
    for (int level = 1; level <= unless_sanitized(6, 4); ++level) {
      INFO(mesh.faces.size() << " faces");
      check_all_results(mesh, level, level % 2 == 0 ? 1 : 4);
    }
}

TEST_CASE("FusedDigest_FansOfEveryValence_IsThatOfSweep") {
  for (std::uint32_t valence = 3; valence <= 40; valence += unless_sanitized(1u, 5u)) {
    INFO("valence " << valence);
    check_all_results(side_by_side({closed_fan(valence), open_fan(valence), bipyramid(valence)}),
                      1 + static_cast<int>(valence % 3));
  }
  check_all_results(closed_fan(1000), 3);
  check_all_results(bipyramid(1000), 2);
  check_all_results(open_fan(1000), 2);
}

TEST_CASE("FusedDigest_TwoFacesBackToBack_IsThatOfSweep") {
  for (const int level : {1, 2, 5}) check_all_results(two_faces_back_to_back(), level);
}

TEST_CASE("FusedDigest_StripsAndSeveralComponents_IsThatOfSweep") {
  check_all_results(sheet(40, 1), 3);
  check_all_results(annulus(17), 4);
  check_all_results(side_by_side({single_triangle(), tetrahedron(), single_triangle(),
                                  seven_vertex_torus(), two_triangles(), sheet(2, 3)}),
                    4);
}

TEST_CASE("FusedDigest_BlocksThreadsAndLayouts_AreTheSame") {
  for (const IndexedMesh& mesh : {random_sphere(61, unless_sanitized(500u, 60u)),
                                  random_sheet(62, unless_sanitized(500u, 60u))}) {
    const BaseMesh base = BaseMesh::build(mesh);
    const SubdivideOptions what{.levels = 4, .normals = true, .limit = true};
    const std::string expected = run(base, what, {}).digest;
    for (std::uint64_t block_bytes = 4 << 10; block_bytes <= (1 << 20); block_bytes *= 4)
      for (const LayoutKind layout :
           {LayoutKind::kGiven, LayoutKind::kSpatial, LayoutKind::kHilbert, LayoutKind::kRcm})
        for (const int threads : {1, 2, 4}) {
          Variant variant = fused_on(threads);
          variant.block_bytes = block_bytes;
          variant.layout = layout;
          INFO(fmt::format("block {} layout {} threads {}", block_bytes, to_string(layout),
                           threads));
          CHECK(run(base, what, variant).digest == expected);
        }
  }
}

TEST_CASE("FusedDigest_FineLevelsOfAMeshInManyRuns_IsThatOfSweep") {
  for (int threads = unless_sanitized(1, 4); threads <= 4; threads += 3) {
    check_all_results(random_sphere(71, unless_sanitized(60, 30)), 6, threads);
    check_all_results(random_sheet(72, unless_sanitized(60, 30)), 6, threads);
  }
}

TEST_CASE("FusedDigest_PositionsOfUncomfortableSize_IsThatOfSweep") {
  for (const double unit : {0.0, 1e-42, 1e-20, 1e-9, 1e9, 1e17, 3e36}) {
    IndexedMesh mesh = random_sheet(81, 60);
    for (Vector3<double>& p : mesh.positions) {
      p = unit * p;
      for (int axis = 0; axis < 3; ++axis) p[axis] = static_cast<float>(p[axis]);
    }
    INFO("unit " << unit);
    check_all_results(mesh, 3);
  }
}

TEST_CASE("FusedSubdivide_WhatItCannotDo_IsRefused") {
  const auto refusal = [](Store& store, const SubdivideOptions& what) {
    try {
      subdivide(store, what);
    } catch (const Error& error) {
      return error.code();
    }
    FAIL("expected an error");
    return ErrorCode::kBadState;
  };
  Store store =
      Store::create({}, BaseMesh::build(icosahedron()), {.backend = "memory"}, default_backends());
  add_base_positions(store);
  SubdivideOptions what{.executor = ExecutorKind::kFused, .levels = 2};
  subdivide(store, what);
  what.levels = 3;
  CHECK(refusal(store, what) == ErrorCode::kNotSupported);
  CHECK(store.finest_level() == 2);
}
