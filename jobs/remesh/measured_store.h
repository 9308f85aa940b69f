// remesh/measured_store.h: how far a scan and the triangles of its store are from each other, and
// whether these pass through others.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "distance/closest_point.h"
#include "plait/base_mesh.h"
#include "remesh/remesh.h"
#include "remesh/scan_progress.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// What is found goes to the report, with the seconds.
class MeasuredStore {
 public:
  /// A part of the scan that is farther away is a warning; in mean edges.
  static constexpr int kFarEdges = 3;

  /// All arguments outlive this object. `scan_tree` has the faces of `scan`.
  MeasuredStore(const RemeshRequest& request, const Surface& scan, const TriangleTree& scan_tree,
                const ScanProgress& progress, const JobWatch& watch, RemeshReport& report)
      : request_(request),
        scan_(scan),
        scan_tree_(scan_tree),
        progress_(progress),
        watch_(watch),
        report_(report) {}

  /// The triangles of the store from now on. `thousandths` of the whole work are done.
  void set_triangles(IndexedMesh mesh, std::uint64_t thousandths);
  void forget_triangles() { triangles_.reset(); }

  // REQUIRES for all others: there are triangles.

  const IndexedMesh& mesh() const { return triangles_->mesh; }
  const TriangleTree& tree() const { return triangles_->tree; }
  /// Both ways. What is farther away than `far` has its places in the report.
  void measure(WorkPart to_store, WorkPart to_scan, double far);
  /// The largest distance of a vertex of the scan.
  double farthest_vertex();
  /// The parts of the scan that are far from the store, and what helps. REQUIRES: measure().
  void warn_of_far_places() const;
  /// Sheets that are nearer to each other than the store is to the scan may pass through each
  /// other, and no distance shows it. Warns of it. `thousandths` of the whole work are done.
  void count_crossings(std::uint64_t thousandths);

 private:
  /// Triangles of the store that are measured, and a tree that points into them.
  struct MeasuredTriangles {
    MeasuredTriangles(IndexedMesh triangles, const std::function<void()>& go_on)
        : mesh(std::move(triangles)), tree(mesh.positions, mesh.faces, go_on) {}
    MeasuredTriangles(const MeasuredTriangles&) = delete;
    MeasuredTriangles& operator=(const MeasuredTriangles&) = delete;

    const IndexedMesh mesh;
    const TriangleTree tree;
  };

  std::string crossings_remedy() const;
  bool sheets_coincide(const Point& p) const;

  const RemeshRequest& request_;
  const Surface& scan_;
  const TriangleTree& scan_tree_;
  const ScanProgress& progress_;
  const JobWatch& watch_;
  RemeshReport& report_;
  std::optional<MeasuredTriangles> triangles_;
};

PLAIT_END_NAMESPACE
