#include "paper/mesh_figures.h"

#include <cstdint>

#include "span_diagram.h"

namespace plait::paper {
namespace {

using nlohmann::json;

json shares_of(const BaseMesh& mesh, int levels) {
  const std::uint64_t border = mesh.border_edge_count(), inner = mesh.edge_count() - border;
  json rows = json::array();
  for (int level = 1; level <= levels; ++level) {
    const std::uint64_t n = std::uint64_t{1} << (level - 1);
    rows.push_back({{"level", level},
                    {"born", inner * n * n + border * (n * (n + 1) / 2)},
                    {"on_base_edges", mesh.edge_count() * n},
                    {"vertices", counts_at_level(mesh, level).vertices},
                    {"replicated", mesh.face_count() * ((2 * n + 1) * (n + 1))}});
  }
  return rows;
}

json spans_of(const BaseMesh& mesh) {
  json rows = json::array();
  for (const LayoutKind kind :
       {LayoutKind::kGiven, LayoutKind::kSpatial, LayoutKind::kHilbert, LayoutKind::kRcm}) {
    const LayoutSpans spans = lay_out(mesh, kind).spans;
    rows.push_back({{"layout", to_string(kind)},
                    {"face", spans.face.span},
                    {"loop", spans.loop.span},
                    {"loop_median", spans.loop.median_width}});
  }
  return rows;
}

}  // namespace

json mesh_tables(const BaseMesh& mesh, int levels) {
  return {{"vertices", mesh.vertex_count()},
          {"edges", mesh.edge_count()},
          {"faces", mesh.face_count()},
          {"euler", static_cast<std::int64_t>(mesh.vertex_count() + mesh.face_count()) -
                        static_cast<std::int64_t>(mesh.edge_count())},
          {"shares", shares_of(mesh, levels)},
          {"spans", spans_of(mesh)}};
}

Image span_picture(const BaseMesh& mesh, LayoutKind order, std::size_t most_width) {
  Image picture = span_diagram(mesh.with_face_order(face_order(mesh, order)));
  while (picture.width() > most_width) picture = halved(picture);
  return picture;
}

Image halved(const Image& image) {
  Image half(image.width() / 2, image.height() / 2, {255, 255, 255});
  for (std::size_t y = 0; y < half.height(); ++y)
    for (std::size_t x = 0; x < half.width(); ++x) {
      int red = 2, green = 2, blue = 2;  // rounds to the nearest
      for (const std::size_t row : {2 * y, 2 * y + 1})
        for (const std::size_t column : {2 * x, 2 * x + 1}) {
          const Rgb& pixel = image.at(column, row);
          red += pixel.red;
          green += pixel.green;
          blue += pixel.blue;
        }
      half.at(x, y) = {static_cast<std::uint8_t>(red / 4), static_cast<std::uint8_t>(green / 4),
                       static_cast<std::uint8_t>(blue / 4)};
    }
  return half;
}

}  // namespace plait::paper
