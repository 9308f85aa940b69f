#include <algorithm>
#include <catch2/catch.hpp>
#include <set>
#include <vector>

#include "plait/error.h"
#include "plait/layout.h"
#include "support/test_meshes.h"

using namespace plait;

namespace {

StencilSpan spans_of(const std::vector<std::set<EdgeId>>& stencils) {
  std::vector<std::uint64_t> widths;
  double sum = 0;
  for (const std::set<EdgeId>& stencil : stencils) {
    widths.push_back(*stencil.rbegin() - *stencil.begin());
    sum += static_cast<double>(widths.back());
  }
  std::sort(widths.begin(), widths.end());
  return {widths.back(), sum / static_cast<double>(widths.size()), widths[(widths.size() - 1) / 2]};
}

/// Computes the spans by the definition: searches all faces for the faces of an edge.
LayoutSpans naive_spans(const BaseMesh& mesh) {
  std::vector<std::set<EdgeId>> faces, loops;
  for (const auto& edges : mesh.face_edges()) faces.emplace_back(edges.begin(), edges.end());
  for (EdgeId edge = 0; edge < mesh.edge_count(); ++edge) {
    std::set<EdgeId> stencil;
    for (const std::set<EdgeId>& face : faces)
      if (face.count(edge) != 0) stencil.insert(face.begin(), face.end());
    loops.push_back(stencil);
  }
  return {spans_of(faces), spans_of(loops)};
}

void check_equal(const StencilSpan& found, const StencilSpan& expected) {
  CHECK(found.span == expected.span);
  CHECK(found.mean_width == Approx(expected.mean_width));
  CHECK(found.median_width == expected.median_width);
}

}  // namespace

TEST_CASE("MeasureSpans_EveryMesh_EqualsTheNaiveComputation") {
  for (const test::NamedMesh& named : test::all_meshes()) {
    INFO(named.name);
    const BaseMesh mesh = BaseMesh::build(named.mesh);
    if (mesh.face_count() > 2000) continue;
    const LayoutSpans found = measure_spans(mesh), expected = naive_spans(mesh);
    check_equal(found.face, expected.face);
    check_equal(found.loop, expected.loop);
  }
}

TEST_CASE("MeasureSpans_SingleTriangle_IsTwo") {
  const LayoutSpans spans = measure_spans(BaseMesh::build(test::single_triangle()));
  for (const StencilSpan& span : {spans.face, spans.loop}) {
    CHECK(span.span == 2);
    CHECK(span.mean_width == 2);
    CHECK(span.median_width == 2);
  }
}

TEST_CASE("MeasureSpans_MeshWithoutFaces_IsZero") {
  CHECK(measure_spans(BaseMesh()).loop.span == 0);
  CHECK(measure_spans(BaseMesh()).face.mean_width == 0);
}

TEST_CASE("WindowBytes_EveryLevel_IsTheSumOfItsLevels") {
  constexpr std::uint64_t kSpan = 3626, kRecordBytes = 12;
  std::uint64_t sum = 0;
  CHECK(window_bytes(kSpan, 0, kRecordBytes) == 0);
  for (int level = 1; level <= 20; ++level) {
    sum += 2 * kSpan * (std::uint64_t{1} << (2 * (level - 1))) * kRecordBytes;
    CHECK(window_bytes(kSpan, level, kRecordBytes) == sum);
  }
}

TEST_CASE("WindowBytes_LevelOutOfRangeOrMoreThan64Bits_IsRefused") {
  CHECK_THROWS_AS(window_bytes(1, -1, 12), Error);
  CHECK_THROWS_AS(window_bytes(1, 21, 12), Error);
  CHECK_THROWS_AS(window_bytes(1u << 31, 20, 2040), Error);
}
