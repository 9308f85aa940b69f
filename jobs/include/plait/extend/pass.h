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
#include <vector>

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
  /// "smooth", "noise", "fractal" or "normals" (kernel is empty then); or the name of an own pass:
  /// 1 to 255 characters of [A-Za-z0-9_-].
  std::string name = "smooth";
  /// smooth: each vertex moves by this part of the way to the mean of its neighbours at the finest
  /// level, those of a border to the mean of the two neighbours on the border. 0 to 1.
  double factor = 0.5;
  /// 0 to 1, in diagonals of the bounding box of all positions. noise: each coordinate moves by
  /// -amplitude to +amplitude, uniformly; the default is 5 to 8 units in the last place of a
  /// float32, as of a fine scanner. fractal: vertices move along the normals, in waves from an
  /// eighth of the diagonal down to four mean edges of the finest level; the longest have the
  /// amplitude, the next ones, half as long, 0.45 of it, and so on; 0.005 looks like rock.
  double amplitude = 3e-7;
  std::uint64_t seed = 1;               ///< noise, fractal: each seed gives another surface
  std::optional<double> diagonal = {};  ///< noise: that of the box; measured if it is not given
  /// smooth, noise, fractal: "normal" too is made, of the new positions. Not in parts.
  bool remakes_normals = false;

  /// Own pass: the attribute that it makes. It replaces one of this name, if there is one. A pass
  /// of the library makes "position", or float32 x 3 "normal".
  AttributeSchema result = {};
  /// Own pass: a text of the program's own, printable ASCII of at most 64 KiB. A plan records it.
  std::string parameters = {};
  PassKernel kernel = {};
};

/// What a pass has measured, in units of the mesh.
struct PassFigures {
  double diagonal = 0;                   ///< noise, fractal: of the bounding box, before
  double mean_edge = 0;                  ///< fractal: of the finest level, before
  std::vector<double> wavelengths = {};  ///< fractal: of the octaves, longest first
  double largest_move = 0;               ///< smooth, noise, fractal: the longest way of a vertex
  /// noise, fractal: vertices whose way is another than was asked for by more than half, because
  /// the type of the positions has no nearer numbers.
  std::uint64_t rounded_moves = 0;
};

/// Makes the pass in this process. The result has as many levels as "position", or, of an own pass,
/// as the attribute that it replaces or otherwise the finest one. If it replaces "position", the
/// provenance names no scheme any more; other attributes stay as they are, but for
/// `remakes_normals`. Does not commit. The progress counts each visit, whose name is the phase.
/// Errors: kInvalidArgument for a pass that does not fit the store, and for a position that is not
/// finite where the bounding box is measured; those of visit_vertices(), Store::replace_attribute()
/// and of the kernel. After an error, roll the store back.
PassFigures run_pass(Store& store, const Pass& pass, const VisitOptions& options = {});

PLAIT_END_NAMESPACE
