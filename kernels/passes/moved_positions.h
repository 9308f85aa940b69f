// What the passes that move vertices share: the type of the positions, and how vertices went.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/extend/vector3.h"
#include "plait/store.h"
#include "plait/visit_vertices.h"
#include "store/base_positions.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Calls pass(Real()) for the type of the numbers of attribute "position". Errors: those of
/// position_of().
template <class Pass>
auto with_real(const Store& store, const Pass& pass) {
  const AttributeId position = position_of(store, "pass over");
  return store.attributes()[position].schema.type == ComponentType::kFloat64 ? pass(double())
                                                                             : pass(float());
}

/// How vertices went in a pass.
struct Moves {
  double longest = 0;  ///< the longest way
  /// Vertices whose way is another than was asked for by more than half, because the type of the
  /// positions has no nearer numbers.
  std::uint64_t rounded = 0;
};

/// Measures the moves of a visit, over all its threads.
class MovesOfVisit {
 public:
  /// REQUIRES: options.threads is the number of threads, not 0.
  explicit MovesOfVisit(const VisitOptions& options)
      : of_threads_(static_cast<std::size_t>(options.threads)) {}
  void add(const VertexRun& run, const Vector3<double>& way) noexcept {
    double& most = of_thread(run).squared;
    most = std::max(most, dot(way, way));
  }
  /// `way` is what the vertex went of what it was to go.
  void add(const VertexRun& run, const Vector3<double>& way,
           const Vector3<double>& asked) noexcept {
    add(run, way);
    const Vector3<double> lost = asked - way;
    if (4 * dot(lost, lost) > dot(asked, asked)) ++of_thread(run).rounded;
  }
  /// After the visit.
  Moves sum() const noexcept {
    Moves moves;
    for (const OfThread& each : of_threads_) {
      moves.longest = std::max(moves.longest, each.squared);
      moves.rounded += each.rounded;
    }
    moves.longest = std::sqrt(moves.longest);
    return moves;
  }

 private:
  /// Of one thread, in a cache line of its own.
  struct alignas(64) OfThread {
    double squared = 0;
    std::uint64_t rounded = 0;
  };
  OfThread& of_thread(const VertexRun& run) noexcept {
    return of_threads_[static_cast<std::size_t>(run.worker)];
  }
  std::vector<OfThread> of_threads_;
};

PLAIT_END_NAMESPACE
