// render/camera.h: projects points of the surface to the picture, with a weak perspective that fits
// the surface.
#pragma once

#include "plait/extend/vector3.h"
#include "render/view.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// A box that add() enlarges to contain each point.
struct Bounds {
  Vector3<double> low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
  void add(const Vector3<double>& point);
  Vector3<double> centre() const { return 0.5 * (low + high); }
  double radius() const;  ///< of the sphere around the box; never 0
};

/// A point of the picture: x to the right and y down in samples; `nearness` is 1 at the middle of
/// the surface, larger in front of it, and linear over a triangle on the screen.
struct ScreenPoint {
  double x = 0, y = 0, nearness = 0;
};

class Camera {
 public:
  /// Looks at the middle of `bounds` from azimuth (around the up axis) and elevation (above the
  /// plane across it). Before fit(), a sample is one unit of the mesh, and the middle is at (0, 0).
  Camera(const Bounds& bounds, const ViewAngles& view, UpAxis up);

  /// Scales and shifts the picture so that the rectangle from (x_low, y_low) to (x_high, y_high)
  /// fills `width` x `height` samples, except for a margin.
  void fit(double x_low, double x_high, double y_low, double y_high, int width, int height);

  ScreenPoint project(const Vector3<double>& point) const;
  /// x to the right, y up, z towards the camera.
  Vector3<float> rotate(const Vector3<float>& direction) const;

  /// The inverse of project, in samples at nearness 1: x to the right, y up, z towards the camera.
  Vector3<float> unproject(float x, float y, float nearness) const;
  /// The surface's radius in samples at nearness 1.
  float radius() const { return static_cast<float>(radius_ * scale_); }

 private:
  Vector3<double> centre_, right_, up_, toward_;
  double radius_, distance_;
  double scale_ = 1, x_shift_ = 0, y_shift_ = 0;
};

PLAIT_END_NAMESPACE
