#include "render/camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr double kCameraDistance = 4.5;  // in radii of the surface
constexpr double kMargin = 0.045;        // in widths of the picture, on every side

}  // namespace

void Bounds::add(const Vector3<double>& point) {
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = std::min(low[axis], point[axis]);
    high[axis] = std::max(high[axis], point[axis]);
  }
}

double Bounds::radius() const {
  const Vector3<double> diagonal = high - low;
  return std::max(0.5 * std::sqrt(dot(diagonal, diagonal)), 1e-30);
}

Camera::Camera(const Bounds& bounds, const ViewAngles& view, UpAxis up)
    : centre_(bounds.centre()), radius_(bounds.radius()), distance_(kCameraDistance * radius_) {
  constexpr double kRadians = std::numbers::pi / 180;
  const double azimuth = view.azimuth * kRadians, elevation = view.elevation * kRadians;
  // First in axes where y is up and azimuth 0 looks along -z. Then the axes of the mesh are
  // exchanged in cyclic order.
  const Vector3<double> axes[3] = {{std::cos(azimuth), 0, -std::sin(azimuth)},
                                   {-std::sin(elevation) * std::sin(azimuth), std::cos(elevation),
                                    -std::sin(elevation) * std::cos(azimuth)},
                                   {std::cos(elevation) * std::sin(azimuth), std::sin(elevation),
                                    std::cos(elevation) * std::cos(azimuth)}};
  const auto to_model = [up](const Vector3<double>& a) -> Vector3<double> {
    switch (up) {
      case UpAxis::kX:
        return {a.y, a.z, a.x};
      case UpAxis::kY:
        return a;
      case UpAxis::kZ:
        return {a.z, a.x, a.y};
    }
    return a;
  };
  right_ = to_model(axes[0]);
  up_ = to_model(axes[1]);
  toward_ = to_model(axes[2]);
}

void Camera::fit(double x_low, double x_high, double y_low, double y_high, int width, int height) {
  const double free = 1 - 2 * kMargin;
  const double x_extent = std::max(x_high - x_low, 1e-30),
               y_extent = std::max(y_high - y_low, 1e-30);
  scale_ = std::min(free * width / x_extent, free * height / y_extent);
  x_shift_ = 0.5 * width - scale_ * 0.5 * (x_low + x_high);
  y_shift_ = 0.5 * height - scale_ * 0.5 * (y_low + y_high);
}

ScreenPoint Camera::project(const Vector3<double>& point) const {
  const Vector3<double> offset = point - centre_;
  // A scheme may put points outside the bounds. Points too close to the camera count as farther
  // away.
  const double away = std::max(distance_ - dot(toward_, offset), 0.05 * distance_);
  const double nearness = distance_ / away;
  return {x_shift_ + scale_ * nearness * dot(right_, offset),
          y_shift_ - scale_ * nearness * dot(up_, offset), nearness};
}

Vector3<float> Camera::rotate(const Vector3<float>& direction) const {
  const Vector3<double> d{direction.x, direction.y, direction.z};
  return {static_cast<float>(dot(right_, d)), static_cast<float>(dot(up_, d)),
          static_cast<float>(dot(toward_, d))};
}

Vector3<float> Camera::unproject(float x, float y, float nearness) const {
  return {(x - static_cast<float>(x_shift_)) / nearness,
          (static_cast<float>(y_shift_) - y) / nearness,
          static_cast<float>(scale_ * distance_) * (1 - 1 / nearness)};
}

PLAIT_END_NAMESPACE
