#include "span_diagram.h"

#include <catch2/catch.hpp>

#include "picture/png_file.h"
#include "plait/error.h"
#include "plait/layout.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

using namespace plait;

namespace {

std::size_t inked_pixels(const Image& image) {
  std::size_t inked = 0;
  for (const Rgb& pixel : image.pixels()) inked += pixel == Rgb{255, 255, 255} ? 0u : 1u;
  return inked;
}

}  // namespace

TEST_CASE("SpanDiagram_EveryMesh_IsOfBoundedSizeAndNotBlank") {
  for (const test::NamedMesh& named : test::all_meshes()) {
    INFO(named.name);
    const Image image = span_diagram(BaseMesh::build(named.mesh));
    CHECK(image.width() >= 800);
    CHECK(image.width() <= 2600);
    CHECK(image.height() <= 1400);
    CHECK(inked_pixels(image) > 1000);
  }
}

TEST_CASE("SpanDiagram_SingleTriangle_FillsBothPanels") {
  // Every stencil uses all three edges, so the dots fill the panels.
  const Image image = span_diagram(BaseMesh::build(test::single_triangle()));
  const std::size_t y = image.height() / 2;
  std::size_t inked = 0;
  for (std::size_t x = 0; x < image.width(); ++x)
    inked += image.at(x, y) == Rgb{255, 255, 255} ? 0u : 1u;
  CHECK(inked == 2 * (480 + 2));
}

TEST_CASE("SpanDiagram_NarrowLayout_HasDotsNearTheDiagonalOnly") {
  const BaseMesh scattered = BaseMesh::build(test::random_torus(9, 3000));
  const BaseMesh narrow = lay_out(scattered, LayoutKind::kRcm).mesh;
  // Looks for dots in the last quarter of the edges and the first quarter of the Loop stencils.
  const auto has_dots_far_out = [](const Image& image) {
    constexpr std::size_t kPanel = 1200, kMarginAndFrame = 25;
    const std::size_t right = image.width() - kMarginAndFrame;
    const std::size_t top = image.height() - kMarginAndFrame - kPanel;
    for (std::size_t y = top; y < top + kPanel / 4; ++y)
      for (std::size_t x = right - kPanel / 4; x < right; ++x)
        if (!(image.at(x, y) == Rgb{255, 255, 255})) return true;
    return false;
  };
  CHECK(has_dots_far_out(span_diagram(scattered)));
  CHECK_FALSE(has_dots_far_out(span_diagram(narrow)));
}

TEST_CASE("SpanDiagram_MeshWithoutFaces_IsRefused") {
  CHECK_THROWS_AS(span_diagram(BaseMesh()), Error);
}

TEST_CASE("DrawSpanDiagram_ToAFile_WritesIt") {
  const test::TemporaryDirectory directory;
  File picture(directory.path() / "spans.png", OpenMode::kCreate);
  draw_span_diagram(BaseMesh::build(test::octahedron()), picture);
  CHECK(std::filesystem::file_size(directory.path() / "spans.png") > 500);
}
