// plait/extend/import_mesh.h: makes a store of a mesh that is semi-regular already: a file whose
// triangles are those of a coarser mesh, split into four again and again. `plait import` is this
// call.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "plait/attribute.h"
#include "plait/detail/namespace.h"
#include "plait/existing.h"
#include "plait/extend/backend_registry.h"
#include "plait/job.h"
#include "plait/layout.h"
#include "plait/options.h"

PLAIT_BEGIN_NAMESPACE

/// What an import shall do.
struct ImportRequest {
  /// PLY, OBJ, OFF or STL, also .gz and .zst; vertices and faces in any order.
  std::filesystem::path mesh;
  std::filesystem::path store;
  /// The number of levels, not more and not fewer. Not set: as many as there are, at least one.
  std::optional<int> levels = {};
  std::string backend = std::string(kAutomaticBackend);  ///< one that is durable
  PipelinesOf pipeline_of = {};                          ///< empty: the default of the backend
  LayoutKind layout = LayoutKind::kAutomatic;
  /// float32 or float64. Not set: as in a PLY file; for formats without types float32, but float64
  /// if float32 moved a vertex by more than a thousandth of the shortest edge there.
  std::optional<ComponentType> precision = {};
  /// Vertices at most so far from each other become one; 0: those of equal positions. Not set: all
  /// stay.
  std::optional<double> weld = {};
  std::uint64_t block_bytes = 0;  ///< as in StoreOptions
  /// If slots of positions would be larger, a finer level becomes the base mesh of the store.
  std::optional<std::uint64_t> max_slot_bytes = {};  ///< 16 KiB
  bool no_index = false;  ///< no file base.index (StoreOptions::base_index)
  std::uint64_t budget_bytes = StoreOptions().budget_bytes;
  int threads = 1;                ///< 0: all processors
  ParallelFor parallel_for = {};  ///< as in StoreOptions
  Durability durability = Durability::kCommit;
  Existing existing = Existing::kRefuse;
  bool ignore_size = false;  ///< start even if the memory seems too small
};

/// What an import did.
struct ImportResult {
  std::uint64_t vertices = 0, faces = 0;  ///< of the file, after the weld
  std::uint64_t merged_vertices = 0;      ///< by the weld
  /// Vertices of borders whose positions others have.
  std::uint64_t seam_vertices = 0;
  int levels = 0;  ///< of the store; its base mesh is at `base_level`
  int base_level = 0;
  std::uint64_t base_vertices = 0, base_faces = 0, border_edges = 0;
  /// The surface has parts without a vertex that must be kept, such as a torus whose vertices all
  /// have six faces. Several base meshes are then equally deep; this one keeps the smallest
  /// vertices.
  bool had_choice = false;
  /// Why there is no further level: the sentence of the error below. Empty if `levels` was given.
  std::string next_level;
  std::vector<AttributeSchema> attributes;
  std::string backend, backend_reason;
  std::uint64_t stored_bytes = 0;
  std::uint64_t memory_bytes = 0;  ///< that the mesh was expected to need, beside the budget
  /// To read the file; to find edges and levels; to write the store.
  double read_seconds = 0, recover_seconds = 0, write_seconds = 0;
};

/// Reads the mesh, finds its levels, and writes positions and the attributes of a PLY file
/// (plait/extend/attributed_mesh.h) to a new store, with the bits of the file. Needs 100 bytes of
/// memory for each vertex, and those of its attributes, beside the budget. Steps, which are the
/// phases too: "read", "connect", "levels", "lay out", "write", "encode", "commit". Errors:
/// kInvalidArgument for a mesh that is no oriented manifold or has fewer levels: the message says
/// how many there are, at which vertex the next one fails, and what was expected; kOutOfMemory
/// before it reads, with the figures; kNotSupported, kBudget, kCancelled, kIo, kNoSpace; those of
/// reading the file. After an error nothing is left. Threads: one call for each thread. Pinned by
/// tests/jobs/import_mesh_test.cpp.
ImportResult import_mesh(const ImportRequest& request, const BackendRegistry& backends,
                         const JobWatch& watch = {});

PLAIT_END_NAMESPACE
