#include "paper/pictures.h"

#include "interrupt.h"
#include "picture/span_diagram.h"
#include "plait/registry.h"
#include "plait/store.h"
#include "plait/subdivide.h"
#include "render/shading.h"
#include "render/surface.h"

namespace plait::paper {
namespace {

constexpr int kTileWidth = 440, kTileHeight = 440;
constexpr ViewAngles kView{35, 20};

Image draw_level(Store& store, int level, int threads) {
  SampleBuffer samples(kTileWidth * kSamplesPerSide, kTileHeight * kSamplesPerSide);
  const Camera camera =
      fitting_camera(store, level, kView, UpAxis::kY, samples.width(), samples.height());
  draw_surface(store, level, camera, samples, [](const Progress&) { return !interrupted(); });
  return shade(samples, camera, threads);
}

void copy_into(Image& to, std::size_t left, const Image& from) {
  for (std::size_t y = 0; y < from.height(); ++y)
    for (std::size_t x = 0; x < from.width(); ++x) to.at(left + x, y) = from.at(x, y);
}

}  // namespace

Image surface_picture(const BaseMesh& mesh, int level, int threads) {
  StoreOptions options;
  options.backend = "memory";
  Store store = Store::create({}, lay_out(mesh, LayoutKind::kHilbert), options, default_backends());
  add_base_positions(store);
  Image picture(std::size_t{2} * kTileWidth, kTileHeight, {255, 255, 255});
  copy_into(picture, 0, draw_level(store, 0, threads));
  SubdivideOptions how;
  how.executor = ExecutorKind::kFused;
  how.levels = level;
  how.normals = true;
  how.threads = threads;
  how.progress = [](const Progress&) { return !interrupted(); };
  subdivide(store, how);
  copy_into(picture, kTileWidth, draw_level(store, level, threads));
  return picture;
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
