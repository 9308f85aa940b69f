// remesh/remesh.h: the job that makes a store from a scan: repair, base mesh, samples, levels,
// report.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "distance/crossings.h"
#include "distance/distances.h"
#include "option_text.h"
#include "plait/attribute.h"
#include "plait/detail/namespace.h"
#include "plait/existing.h"
#include "plait/extend/backend_registry.h"
#include "plait/extend/rounding.h"
#include "plait/job.h"
#include "plait/options.h"
#include "sample/area_spread.h"
#include "surface/repair.h"

PLAIT_BEGIN_NAMESPACE

struct RemeshRequest {
  std::filesystem::path scan;   ///< a mesh file, as read_attributed_mesh() reads it
  std::filesystem::path store;  ///< gets its name when it is complete
  /// Of the base mesh, at most (one more for a closed surface, or 5 %). With max_distance, the base
  /// mesh that is tried first; 0: a thousandth of the scan's.
  std::uint64_t faces = 0;
  int levels = 3;  ///< 1 or more; with max_distance, at most
  /// Base meshes of more and more faces are made, up to the scan, until no point of the report in
  /// either direction is farther: a length, or a part of the scan's diagonal.
  std::optional<RelativeLength> max_distance = {};
  /// Whether each face has a depth of its own (docs/adaptive.md): one with which what is drawn is
  /// within max_distance too. Not set: with max_distance. Faces differ from their neighbours by at
  /// most one level.
  std::optional<bool> own_depths = {};
  SurfaceRepairOptions repair = {};
  /// float32 or float64. Not set: float32, but float64 if float32 moved a vertex of the scan by
  /// more than a thousandth of the shortest edge there.
  std::optional<ComponentType> precision = {};
  /// Vertices of the scan at most so far from each other become one; 0: those of equal positions.
  /// Not set: all stay.
  std::optional<double> weld = {};
  /// Edges of the scan that turn by more degrees stay sharp: base edges and vertices of all levels
  /// are on them (surface/creases.h). 180: none. Not set: chosen from the angles of the scan.
  std::optional<double> feature_angle = {};
  /// Where small triangles stay turned over, the base mesh is made anew, with more of its faces
  /// there, up to seven times. An error if some are left.
  bool refuse_turned = false;
  /// Adds attribute "distance" (float32): at each vertex, how far the vertices of the scan near it
  /// are from the store, in units of the scan.
  bool distances = false;
  /// Positions of all levels and of the base mesh are rounded (remesh/rounded_positions.h).
  std::optional<ErrorBound> max_error = {};
  /// Points for each direction of the report; 0 for no distances.
  std::uint64_t report_samples = 1000000;
  StoreOptions options = {};  ///< pipelines: only with a backend that compresses
  int threads = 1;
  bool digest = false;
  bool ignore_size = false;  ///< start even if the memory of the machine is too small
  Existing existing = Existing::kRefuse;
};

/// The shape of the base mesh's faces (triangle_quality()), and of its vertices.
struct BaseShape {
  double least_quality = 0, percentile_1_quality = 0, median_quality = 0;
  std::uint64_t largest_valence = 0;
};

struct RemeshReport {
  RepairList repairs;
  /// Vertices of the file that the weld merged, and those of borders whose positions others have.
  std::uint64_t merged_vertices = 0, seam_vertices = 0;
  ComponentType precision = ComponentType::kFloat32;  ///< of the positions
  /// Of the scan's coordinates, if their digits were lost before (lost_step() in
  /// mesh/narrowing.h), which is a warning. Otherwise 0.
  double lost_step = 0;
  SurfaceFigures scan, base;                    ///< after the repair; of the base mesh
  std::uint64_t vertices = 0, small_faces = 0;  ///< of the finest level, as it is drawn
  /// Of the finest level of all faces, if faces have depths of their own; else as `vertices`.
  std::uint64_t from_vertices = 0, from_faces = 0;
  std::vector<std::uint64_t> faces_of_level = {};  ///< [depth] faces; empty without depths
  double tolerance = 0;  ///< of the depths: largest distance from all levels
  /// If the base mesh has more faces than asked for: the edges left that could not collapse,
  /// because genus, borders or components would change, or because a face would turn or become a
  /// needle.
  std::uint64_t kept_by_topology = 0, kept_by_shape = 0;
  double feature_angle = 180;                          ///< degrees; 180 if no edge is a crease
  std::uint64_t crease_edges = 0, crease_corners = 0;  ///< of the scan
  /// The fewest base faces with the creases that were found, if they are more than asked for and
  /// the request has no feature angle: then no edge is a crease, which is a warning. Otherwise 0.
  std::uint64_t faces_for_creases = 0;
  std::uint64_t exact_faces = 0;      ///< of the base mesh: they lie on the scan before relax()
  std::uint64_t relaxed_samples = 0;  ///< moved by relax()
  std::uint64_t turned_before = 0, turned = 0, moved_samples = 0;  ///< by untangle()
  std::uint64_t folds = 0;  ///< edges of small triangles (sample/folds.h)
  /// Of the scan, and of the small triangles of all levels, with distances in the report. More of
  /// the store than of the scan are a warning.
  Crossings scan_crossings, crossings;
  std::uint64_t faces_asked = 0;   ///< of the last base mesh
  int levels = 0;                  ///< of the store
  double max_distance = 0;         ///< in units of the scan; 0: none was asked for
  std::uint64_t trials = 0;        ///< base meshes that max_distance needed
  std::uint64_t depth_trials = 0;  ///< tolerances that the depths needed
  std::uint64_t base_meshes = 0;   ///< that were tried; more than one only with refuse_turned
  BaseShape shape;
  AreaSpread area_spread;
  double diagonal = 0, mean_edge = 0;       ///< of the scan
  std::vector<AttributeSchema> attributes;  ///< of the scan, that came along
  /// Face attributes, from properties of the scan's faces, and how many base faces have more than
  /// one number of the scan each (remesh/scan_face_attributes.h).
  std::vector<AttributeSchema> face_attributes;
  std::vector<std::uint64_t> mixed_faces;
  /// Without samples if the request asks for none. Parts of the scan that are farther than 3 mean
  /// edges from the store are a warning too.
  Distances to_store, to_scan;
  std::optional<Rounding> rounding;  ///< of the positions
  std::string backend, digest;
  std::uint64_t stored_bytes = 0;
  double prune_seconds = 0;  ///< of the depths, without measuring
  double read_seconds = 0, repair_seconds = 0, decimate_seconds = 0, sample_seconds = 0,
         relax_seconds = 0, untangle_seconds = 0, write_seconds = 0, report_seconds = 0;
};

/// Makes the store: attribute "position" (3 x float32 or float64) on all levels, at points of the
/// scan, the vertex attributes of a PLY file there (remesh/scan_attributes.h), the scalar
/// properties of its faces as face attributes (remesh/scan_face_attributes.h), the face attribute
/// "crease-sides" (export/crease_normals.h) if there are sharp edges, and "turned"
/// (uint8): 1 at the corners of small triangles that stay turned over, 0 elsewhere. With distances
/// in the report, the text "remesh-rms" has the larger root of the mean square, in units of the
/// scan. After an error there is no new store.
///
/// Progress counts thousandths of the whole work; there are no other steps. It is told about
/// every half second or more often, but for reading and repairing large files.
///
/// The same scan and request give the same bits for any number of threads. Memory: about 200 bytes
/// for each face of the scan and 140 for each small face, 200 with depths, and the budget. The
/// levels of all faces are never on the disk then. Errors: those of
/// read_attributed_mesh(), repair() and Store::create(); kInvalidArgument for counts that do not
/// fit, for a base mesh of more than 1.05 times the faces asked for, with refuse_turned, and with
/// max_distance if no base mesh comes within it, and for own_depths without max_distance;
/// kOutOfMemory before the work begins; kCancelled. Pinned by tests/jobs/remesh_test.cpp.
RemeshReport remesh(const RemeshRequest& request, const BackendRegistry& backends,
                    const JobWatch& watch = {});

PLAIT_END_NAMESPACE
