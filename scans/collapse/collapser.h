// collapse/collapser.h: collapses edges of a mesh, cheapest first.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "collapse/border_corners.h"
#include "collapse/collapse_history.h"
#include "collapse/collapsing_mesh.h"
#include "collapse/patch.h"
#include "collapse/quadric.h"
#include "plait/detail/namespace.h"
#include "surface/surface.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The limits of a stage of the work (decimate.cpp).
struct ShapeLimits {
  double least_quality;  ///< of a new face, unless the old face is worse
  double least_turn;     ///< cosine of the angle between the normals of a face before and after
  double least_cone;     ///< cosine of the angle between a new face's normal and the fan's
};

/// A mesh on the way from a scan to its base mesh.
struct CollapseState {
  CollapseState(const Surface& scan, const Creases& creases)
      : mesh(scan, creases, border_corners(scan)),
        history(scan.faces.size(), creases.edge_count > 0),
        quadrics(scan.positions.size()),
        stamps(scan.positions.size(), 0),
        carried(scan.faces.size()),
        waits(3 * scan.faces.size(), 0) {}

  CollapsingMesh mesh;
  CollapseHistory history;
  std::vector<Point> positions;  ///< in diagonals of the scan, from its middle
  std::vector<Quadric> quadrics;
  std::vector<std::uint32_t> stamps;  ///< counts the changes of a vertex
  std::vector<float> carried;         ///< [face] area of the scan that the face stands for
  std::vector<std::uint8_t> waits;    ///< [side] whether a queue has the edge by this side
  /// [vertex] the tile that all its faces are in, or kNoId. Empty: no tiles.
  std::vector<std::uint32_t> tiles;
};

/// Why edges could not collapse.
struct CollapseRefusals {
  std::uint64_t by_topology = 0, by_shape = 0;
};

/// Works on all edges, or on those inside of a tile. Threads: one collapser for each tile at once.
class Collapser {
 public:
  static constexpr std::uint32_t kWhole = kNoId;

  Collapser(CollapseState& state, std::uint32_t tile) : state_(state), tile_(tile) {}

  /// Collapses edges of `faces`, cheapest first, until at least `count` faces are gone, or no edge
  /// fits the limits. Calls `tell` now and then. Returns how many are gone.
  std::uint64_t collapse(std::span<const FaceId> faces, const ShapeLimits& limits,
                         std::uint64_t count, const std::function<void()>& tell);
  /// Why the edges of `faces` do not collapse.
  CollapseRefusals refusals(std::span<const FaceId> faces, const ShapeLimits& limits,
                            const std::function<void()>& tell);

 private:
  struct Candidate {
    float cost;
    FaceSide edge;
    std::uint32_t stamp;  ///< sum of the stamps of its ends

    friend bool operator<(const Candidate& a, const Candidate& b) {  // the cheapest is the largest
      return a.cost != b.cost ? a.cost > b.cost : a.edge.code > b.edge.code;
    }
  };

  bool is_inside(FaceSide edge) const {
    return tile_ == kWhole || (state_.tiles[state_.mesh.start(edge)] == tile_ &&
                               state_.tiles[state_.mesh.end(edge)] == tile_);
  }
  void fill_queue(std::span<const FaceId> faces, const std::function<void()>& tell);
  /// Values an edge anew, and puts it into the queue if it can collapse.
  void offer(FaceSide edge);
  void push(FaceSide edge);
  /// Returns how many faces are gone.
  std::uint64_t try_collapse(FaceSide edge);
  void shape_patch(const Patch& patch, PatchShape& shape) const;
  /// Whether the fan's faces fit the limits. Sets their area, and their worst quality.
  bool fan_fits(const Patch& patch, const PatchShape& shape);
  void share_area(const Patch& patch);

  CollapseState& state_;
  std::uint32_t tile_;
  std::vector<Candidate> queue_;
  CollapseHistory::Room room_;
  ShapeLimits limits_{};
  Point fan_normal_{};
  double fan_area_ = 0, fan_quality_ = 0;
  std::array<double, kMaxFan> face_areas_{};
  CollapseRefusals refused_;
  Patch patch_;
  PatchShape shape_;
};

PLAIT_END_NAMESPACE
