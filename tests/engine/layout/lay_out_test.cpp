#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <set>
#include <vector>

#include "layout/spans.h"
#include "plait/error.h"
#include "plait/layout.h"
#include "plait/mesh_io.h"
#include "support/real_meshes.h"
#include "support/test_meshes.h"

namespace plait::test {
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

namespace {

constexpr std::array kLayoutOrders{LayoutKind::kGiven, LayoutKind::kSpatial, LayoutKind::kHilbert,
                                   LayoutKind::kRcm};

struct NamedEdge {
  VertexId start, end;
  std::array<VertexId, 3> own_face;
  friend auto operator<=>(const NamedEdge&, const NamedEdge&) = default;
};

/// The edges of a mesh, described without the numbers of faces and edges.
std::vector<NamedEdge> edges_of(const BaseMesh& mesh) {
  std::vector<NamedEdge> edges;
  for (const Edge& edge : mesh.edges())
    edges.push_back({edge.start, edge.end, mesh.faces()[edge.own.face()]});
  std::sort(edges.begin(), edges.end());
  return edges;
}

std::vector<std::array<VertexId, 3>> faces_of(const BaseMesh& mesh) {
  std::vector<std::array<VertexId, 3>> faces(mesh.faces().begin(), mesh.faces().end());
  std::sort(faces.begin(), faces.end());
  return faces;
}

bool have_same_edges(const BaseMesh& a, const BaseMesh& b) {
  return std::equal(a.edges().begin(), a.edges().end(), b.edges().begin(), b.edges().end(),
                    [](const Edge& x, const Edge& y) {
                      return x.start == y.start && x.end == y.end && x.own == y.own &&
                             x.other == y.other;
                    });
}

}  // namespace

TEST_CASE("LayOut_EveryOrder_LeavesTheMeshTheSameButForItsNumbers") {
  for (const test::NamedMesh& named : test::all_meshes()) {
    const BaseMesh mesh = BaseMesh::build(named.mesh);
    for (const LayoutKind kind : kLayoutOrders) {
      INFO(named.name << " " << to_string(kind));
      const LaidOutMesh laid_out = lay_out(mesh, kind);
      CHECK(laid_out.kind == kind);
      CHECK(std::equal(mesh.positions().begin(), mesh.positions().end(),
                       laid_out.mesh.positions().begin(), laid_out.mesh.positions().end()));
      CHECK(faces_of(laid_out.mesh) == faces_of(mesh));
      CHECK(edges_of(laid_out.mesh) == edges_of(mesh));
      CHECK(laid_out.mesh.border_edge_count() == mesh.border_edge_count());
    }
  }
}

TEST_CASE("LayOut_EveryOrder_ReportsTheSpansOfTheMeshItReturns") {
  for (const test::NamedMesh& named : test::all_meshes()) {
    const BaseMesh mesh = BaseMesh::build(named.mesh);
    for (const LayoutKind kind : kLayoutOrders) {
      INFO(named.name << " " << to_string(kind));
      const LaidOutMesh laid_out = lay_out(mesh, kind);
      const LayoutSpans measured = measure_spans(laid_out.mesh);
      CHECK(laid_out.spans.face.span == measured.face.span);
      CHECK(laid_out.spans.loop.span == measured.loop.span);
      CHECK(laid_out.spans.face.mean_width == measured.face.mean_width);
      CHECK(laid_out.spans.loop.mean_width == measured.loop.mean_width);
      CHECK(laid_out.spans.loop.median_width == measured.loop.median_width);
    }
  }
}

TEST_CASE("LayOut_Automatic_TakesTheFirstOfThoseOfSmallestLoopSpan") {
  for (const test::NamedMesh& named : test::all_meshes()) {
    INFO(named.name);
    const BaseMesh mesh = BaseMesh::build(named.mesh);
    LayoutKind best = LayoutKind::kSpatial;
    std::uint64_t best_span = lay_out(mesh, best).spans.loop.span;
    for (const LayoutKind kind : {LayoutKind::kHilbert, LayoutKind::kRcm}) {
      const std::uint64_t span = lay_out(mesh, kind).spans.loop.span;
      if (span < best_span) {
        best = kind;
        best_span = span;
      }
    }
    const LaidOutMesh chosen = lay_out(mesh, LayoutKind::kAutomatic);
    CHECK(chosen.kind == best);
    CHECK(chosen.spans.loop.span == best_span);
    CHECK(have_same_edges(chosen.mesh, lay_out(mesh, best).mesh));
  }
}

TEST_CASE("LayOut_RealMesh_RcmNeedsTheSmallestWindow") {
  if (!test::has_real_mesh("spot")) return;
  const BaseMesh mesh = read_base_mesh(test::real_mesh_path("spot"));
  const LaidOutMesh chosen = lay_out(mesh, LayoutKind::kAutomatic);
  CHECK(chosen.kind == LayoutKind::kRcm);
  for (const LayoutKind kind : {LayoutKind::kSpatial, LayoutKind::kHilbert})
    CHECK(chosen.spans.loop.span < lay_out(mesh, kind).spans.loop.span);
}

}  // namespace plait::test
