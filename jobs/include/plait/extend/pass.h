// plait/extend/pass.h: a pass over all vertices of a store that makes one attribute: a pass of the
// library (smoothing, noise, normals), or one of the program's own. run_pass() makes it in one
// process; plait/extend/parts.h makes it in parts, on many machines, with the same bits.
//
//   Pass pass{.name = "curvature", .result = schema_of<float>("curvature")};
//   pass.kernel = [](Store& store, const std::string& into, const VisitOptions& options) {
//     visit_vertices(store, options, std::tuple{rings_of<Point>("position"),
//     overwrites<float>(into)},
//                    [](const VertexRun& run, const VertexRings<Point>& ring, std::span<float> to)
//                    {
//                      ...
//                    });
//   };
//
// Pinned by tests/jobs/pass_test.cpp.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "plait/attribute.h"
#include "plait/detail/namespace.h"
#include "plait/store.h"
#include "plait/visit_vertices.h"

PLAIT_BEGIN_NAMESPACE

/// The computation of a program's own pass: fills attribute `into` for all vertices, by
/// visit_vertices() with these options. It reads other attributes of the store, and does not change
/// the store otherwise. In a part, a visit goes over the vertices of the part alone, so what the
/// kernel collects beside the records is that of the part. May throw.
using PassKernel =
    std::function<void(Store& store, const std::string& into, const VisitOptions& options)>;

/// What a pass computes.
struct Pass {
  /// "smooth", "noise" or "normals" (kernel is empty then); or the name of an own pass: 1 to 255
  /// characters of [A-Za-z0-9_-].
  std::string name = "smooth";
  /// smooth: each vertex moves by this part of the way to the mean of its neighbours at the finest
  /// level, those of a border to the mean of the two neighbours on the border. 0 to 1.
  double factor = 0.5;
  /// noise: each coordinate moves by -amplitude to +amplitude diagonals of the bounding box of all
  /// positions, uniformly, and as plait displace moves it. 0 to 1.
  double amplitude = 3e-7;
  std::uint64_t seed = 1;
  std::optional<double> diagonal = {};  ///< noise: that of the box; measured if it is not given

  /// Own pass: the attribute that it makes. It replaces one of this name, if there is one. A pass
  /// of the library makes "position", or float32 x 3 "normal".
  AttributeSchema result = {};
  /// Own pass: a text of the program's own, printable ASCII of at most 64 KiB. A plan records it.
  std::string parameters = {};
  PassKernel kernel = {};
};

/// Makes the pass in this process. The result has as many levels as "position", or, of an own pass,
/// as the attribute that it replaces or otherwise the finest one. If it replaces "position", the
/// provenance names no scheme any more; other attributes stay as they are. Does not commit. Errors:
/// kInvalidArgument for a pass that does not fit the store; those of visit_vertices(),
/// Store::replace_attribute() and of the kernel. After an error, roll the store back.
void run_pass(Store& store, const Pass& pass, const VisitOptions& options = {});

PLAIT_END_NAMESPACE
