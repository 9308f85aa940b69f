#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "picture/color_map.h"
#include "plait/error.h"
#include "render/camera.h"
#include "render/sample_buffer.h"
#include "render/shading.h"
#include "render/view.h"

namespace plait::test {
namespace {

RasterVertex vertex(double x, double y, double nearness = 1, Vector3<float> normal = {0, 0, 1}) {
  return raster_vertex({x, y, nearness}, normal);
}

Camera square_camera(int side) {
  Bounds bounds;
  bounds.add({-1, -1, -1});
  bounds.add({1, 1, 1});
  Camera camera(bounds, {0, 0}, UpAxis::kY);
  camera.fit(-1, 1, -1, 1, side, side);
  return camera;
}

}  // namespace

TEST_CASE("SampleBuffer_FanOfThinTriangles_LeavesNoGap") {
  SampleBuffer samples(64, 64);
  std::mt19937_64 random(5);
  // Points along the outline of a square, in order. The triangles from an inner point to them cover
  // the square.
  std::vector<RasterVertex> outline;
  for (int side = 0; side < 4; ++side)
    for (int step = 0; step < 500; ++step) {
      const double t = step / 500.0 * 64;
      outline.push_back(side == 0   ? vertex(t, 0)
                        : side == 1 ? vertex(64, t)
                        : side == 2 ? vertex(64 - t, 64)
                                    : vertex(0, 64 - t));
    }
  const RasterVertex centre = vertex(31.37, 20.11);
  for (std::size_t i = 0; i < outline.size(); ++i)
    samples.draw(centre, outline[i], outline[(i + 1) % outline.size()]);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) CHECK_FALSE(samples.at(x, y).empty());
}

TEST_CASE("SampleBuffer_TwoSurfaces_KeepsTheNearerInEitherOrder") {
  for (const bool near_first : {false, true}) {
    SampleBuffer samples(8, 8);
    const auto draw = [&](double nearness) {
      samples.draw(vertex(0, 8, nearness), vertex(16, 8, nearness), vertex(0, -8, nearness));
    };
    draw(near_first ? 1.2 : 0.9);
    draw(near_first ? 0.9 : 1.2);
    CHECK(samples.at(2, 4).nearness == Approx(1.2));
  }
}

TEST_CASE("SampleBuffer_BothWindings_TellFrontFromBackAndTurnTheNormal") {
  SampleBuffer front(4, 4), back(4, 4);
  const Vector3<float> tilted = normalized(Vector3<float>{0.3f, -0.2f, 1});
  const RasterVertex a = vertex(0, 4, 1, tilted), b = vertex(8, 4, 1, tilted),
                     c = vertex(0, -4, 1, tilted);
  front.draw(a, b, c);
  CHECK_FALSE(front.at(1, 2).is_back());
  CHECK(front.at(1, 2).normal().x == Approx(tilted.x).margin(1e-3));
  CHECK(front.at(1, 2).normal().z == Approx(tilted.z).margin(1e-3));
  const Vector3<float> away = -1.f * tilted;
  back.draw(vertex(0, 4, 1, away), vertex(0, -4, 1, away), vertex(8, 4, 1, away));
  CHECK(back.at(1, 2).is_back());
  CHECK(back.at(1, 2).normal().x == Approx(tilted.x).margin(1e-3));
}

TEST_CASE("SampleBuffer_TrianglesOutsideAndDegenerate_AreLeftOut") {
  SampleBuffer samples(4, 4);
  samples.draw(vertex(-10, -10), vertex(-5, -10), vertex(-10, -5));
  samples.draw(vertex(1e30, 0), vertex(2e30, 0), vertex(1e30, 5));
  samples.draw(vertex(0, 0), vertex(2, 2), vertex(4, 4));
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 4; ++x) CHECK(samples.at(x, y).empty());
}

TEST_CASE("Camera_PointsOfTheModel_AreInvertedByUnproject") {
  const Camera camera = square_camera(200);
  for (const Vector3<double>& point : {Vector3<double>{0, 0, 0}, {0.5, -0.25, 0.75}, {-1, 1, -1}}) {
    const ScreenPoint at = camera.project(point);
    const Vector3<float> back = camera.unproject(static_cast<float>(at.x), static_cast<float>(at.y),
                                                 static_cast<float>(at.nearness));
    const float scale = camera.radius() / std::sqrt(3.f);
    CHECK(back.x / scale == Approx(point.x).margin(1e-4));
    CHECK(back.y / scale == Approx(point.y).margin(1e-4));
    CHECK(back.z / scale == Approx(point.z).margin(1e-4));
  }
}

TEST_CASE("Camera_AnyView_IsARightHandedRotation") {
  Bounds bounds;
  bounds.add({-1, -1, -1});
  bounds.add({1, 1, 1});
  for (const UpAxis up : {UpAxis::kX, UpAxis::kY, UpAxis::kZ})
    for (const double azimuth : {-100.0, 0.0, 35.0, 200.0})
      for (const double elevation : {-90.0, 0.0, 20.0}) {
        const Camera camera(bounds, {azimuth, elevation}, up);
        const Vector3<float> x = camera.rotate({1, 0, 0}), y = camera.rotate({0, 1, 0}),
                             z = camera.rotate({0, 0, 1});
        CHECK(dot(cross(x, y), z) == Approx(1).epsilon(1e-5));
        const Vector3<float> upwards = up == UpAxis::kX ? x : up == UpAxis::kY ? y : z;
        CHECK(upwards.x == Approx(0).margin(1e-6));
        CHECK(upwards.y >= -1e-6f);
      }
}

TEST_CASE("Shade_AnyThreadCount_GivesOnePicture") {
  SampleBuffer samples(64, 64);
  const Camera camera = square_camera(64);
  samples.draw(vertex(5, 60, 0.9), vertex(60, 50, 1.1, {0.6f, 0, 0.8f}), vertex(30, 3));
  samples.draw(vertex(5, 30, 1.2), vertex(30, 50, 0.7, {0, 0.6f, 0.8f}), vertex(60, 3));
  const Image one = shade(samples, camera, {{}, 1}), three = shade(samples, camera, {{}, 3});
  CHECK(one.width() == 32);
  CHECK(std::ranges::equal(one.pixels(), three.pixels()));
}

TEST_CASE("Shade_AReportThatThrows_EndsTheWork") {
  SampleBuffer samples(64, 64);
  const Camera camera = square_camera(64);
  int rows = 0;
  const auto report = [&] {
    if (++rows == 5) throw Error(ErrorCode::kCancelled, "render: cancelled");
  };
  CHECK_THROWS_AS(shade(samples, camera, {{}, 1, report}), Error);
  CHECK(rows == 5);
}

TEST_CASE("ColorOfShare_FromLowToHigh_GetsLighterEvenly") {
  // Lightness by CIE 1976, from the luminance of the linear colour.
  const auto lightness = [](Rgb color) {
    const auto linear = [](std::uint8_t value) { return std::pow(value / 255.0, 2.2); };
    const double y =
        0.2126 * linear(color.red) + 0.7152 * linear(color.green) + 0.0722 * linear(color.blue);
    return 116 * std::cbrt(y) - 16;
  };
  for (int i = 0; i < 20; ++i) {
    const double step =
        lightness(color_of_share((i + 1) / 20.0)) - lightness(color_of_share(i / 20.0));
    CHECK(step > 2);
    CHECK(step < 6);
  }
  CHECK(color_of_share(-1) == color_of_share(0));
  CHECK(color_of_share(2) == color_of_share(1));
}

TEST_CASE("SampleBuffer_Shares_AreInterpolatedAndTellWhereThereIsNone") {
  SampleBuffer samples(64, 64, true);
  const auto with_share = [](RasterVertex vertex, float share) {
    vertex.share = share;
    return vertex;
  };
  samples.draw(with_share(vertex(0, 0), 0), with_share(vertex(0, 64), 0),
               with_share(vertex(64, 0), 1));
  CHECK(samples.share(16, 8) == Approx(16.5 / 64).margin(1e-3));
  CHECK(samples.share(48, 8) == Approx(48.5 / 64).margin(1e-3));
  samples.draw(with_share(vertex(0, 0, 2), NAN), with_share(vertex(0, 64, 2), 0),
               with_share(vertex(64, 0, 2), 1));
  CHECK(samples.share(16, 8) < 0);
}

TEST_CASE("ParsePictureSize_TextOfAnyKind_IsASizeOrRefused") {
  CHECK(parse_picture_size("640x480").width == 640);
  CHECK(parse_picture_size("1x8192").height == 8192);
  for (const char* text : {"", "640", "640x", "x480", "640x0", "0x480", "-1x5", "640x480x2",
                           "8193x10", "640X480", "640 x480", "99999999999x1"}) {
    CAPTURE(text);
    CHECK_THROWS_AS(parse_picture_size(text), Error);
  }
}

TEST_CASE("ParseView_TextOfAnyKind_IsAViewOrRefused") {
  CHECK(parse_view("-30,20.5").azimuth == -30);
  CHECK(parse_view("-30,20.5").elevation == 20.5);
  for (const char* text : {"", "30", "30,", ",20", "30,91", "361,0", "nan,0", "0,inf", "1,2,3"}) {
    CAPTURE(text);
    CHECK_THROWS_AS(parse_view(text), Error);
  }
}

}  // namespace plait::test
