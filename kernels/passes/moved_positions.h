// What the passes that move vertices share: the type of the positions, and how far vertices went.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/extend/store_access.h"
#include "plait/extend/vector3.h"
#include "plait/store.h"
#include "plait/visit_vertices.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Calls pass(Real()) for the type of the numbers of attribute "position". Errors: kInvalidArgument
/// unless it is float32 x 3 or float64 x 3.
template <class Pass>
auto with_real(const Store& store, const Pass& pass) {
  const AttributeId position = store.attribute("position");
  if (store.attributes()[position].schema.type == ComponentType::kFloat64) {
    StoreAccess::check_type(store, position, ComponentType::kFloat64, 3);
    return pass(double());
  }
  StoreAccess::check_type(store, position, ComponentType::kFloat32, 3);
  return pass(float());
}

/// The longest way of a vertex, over all threads of a visit.
class LongestMove {
 public:
  /// REQUIRES: options.threads is the number of threads, not 0.
  explicit LongestMove(const VisitOptions& options)
      : squares_(static_cast<std::size_t>(options.threads)) {}
  void add(const VertexRun& run, const Vector3<double>& way) noexcept {
    double& most = squares_[static_cast<std::size_t>(run.worker)].most;
    most = std::max(most, dot(way, way));
  }
  /// After the visit.
  double length() const noexcept {
    double most = 0;
    for (const Square& square : squares_) most = std::max(most, square.most);
    return std::sqrt(most);
  }

 private:
  /// Of one thread, in a cache line of its own.
  struct alignas(64) Square {
    double most = 0;
  };
  std::vector<Square> squares_;
};

PLAIT_END_NAMESPACE
