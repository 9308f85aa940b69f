// plait/subdivision_job.h: one job that makes a store from a mesh. A program can plan,
// start, watch, cancel and resume the job. `plait subdivide` is such a program, and
// examples/watched_job.cpp is a short one.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "plait/attribute.h"
#include "plait/base_mesh.h"
#include "plait/detail/namespace.h"
#include "plait/existing.h"
#include "plait/extend/backend_registry.h"
#include "plait/extend/pager.h"
#include "plait/extend/rounding.h"
#include "plait/job.h"
#include "plait/layout.h"
#include "plait/options.h"
#include "plait/store.h"
#include "plait/subdivide.h"

PLAIT_BEGIN_NAMESPACE

/// What a job shall do. Members that have no value get one from the store of an earlier run, or a
/// default.
struct SubdivisionRequest {
  /// The path of a file (PLY, OBJ or OFF, also .gz and .zst), or a mesh.
  std::variant<std::filesystem::path, BaseMesh> mesh;
  /// May be empty if the backend is not durable.
  std::filesystem::path store = {};
  /// Vertices of the file at most so far from each other become one; 0: those of equal positions.
  /// Not set: all stay. Only for a file.
  std::optional<double> weld = {};
  int levels = 1;  ///< the level to reach, counted from the mesh

  // Properties of the store. A resumed job takes them from the store, and refuses a value that
  // differs. For a new store, the comment of each member names its default.
  std::optional<std::string> backend = {};  ///< "auto" (BackendRegistry::choose)
  /// The pipelines of each attribute (plait/extend/pipeline.h); empty: the default of the
  /// backend. If blocks are encoded from other blocks, the job encodes the attribute anew when all
  /// levels are made.
  PipelinesOf pipeline_of = {};
  std::optional<LayoutKind> layout = {};  ///< Hilbert for fused, else kAutomatic
  /// Loop. The store records the name of a program's own rule alone, so a job that continues the
  /// store needs the rule again.
  std::optional<Scheme> scheme = {};
  /// float32, but float64 if float32 moved a vertex of the mesh by more than a thousandth of the
  /// shortest edge there.
  std::optional<ComponentType> precision = {};
  std::optional<std::uint64_t> block_bytes = {};     ///< as in StoreOptions
  std::optional<std::uint64_t> max_slot_bytes = {};  ///< 16 KiB; decides the base level
  bool no_index = false;  ///< no file base.index (StoreOptions::base_index)

  /// Attributes that are rounded when all levels are made (plait/extend/rounding.h). Until the
  /// commit, their exact and their rounded levels take disk space. Their pipelines count in steps
  /// (pipeline_of_rounded() of plait/compression.h). Not with `resume`.
  ErrorBounds max_errors = {};
  /// Reads the rounded levels before the exact ones go, and compares every record.
  bool verify = false;

  /// Each face keeps its levels up to a depth of its own (docs/adaptive.md), with which the finest
  /// level and what is drawn are at most so far from each other: a length, or with
  /// `distance_in_diagonals` a part of the diagonal of the box around the base vertices. Neighbours
  /// differ by one level at most. Until the commit, the levels of all faces take disk space. Not
  /// with `resume`, and not for a backend that is not durable.
  std::optional<double> max_distance = {};
  bool distance_in_diagonals = false;

  ExecutorKind executor = ExecutorKind::kAuto;  ///< sweep with `resume`, else fused
  std::uint64_t budget_bytes = StoreOptions().budget_bytes;
  int threads = 1;
  ParallelFor parallel_for = {};  ///< as in StoreOptions
  bool normals = false;
  bool limit = false;
  /// With kNone, the job never waits for the disk. If the job is cancelled or killed, the last
  /// commit stays; but a crash of the system may destroy the store.
  Durability durability = Durability::kCommit;
  bool digest = false;                    ///< at the end, read all levels and compute the digest
  bool ignore_size = false;               ///< start even if memory or disk are too small
  Existing existing = Existing::kRefuse;  ///< not kReplace with `resume`
  /// Continues from the last commit of a store of this name. The job makes the store under its
  /// final name and commits every level, so that a later job can resume it.
  bool resume = false;
};

/// Counts of the mesh of a job.
struct MeshFigures {
  std::uint64_t vertices = 0, edges = 0, faces = 0, border_edges = 0;
};

/// Estimates from the counts of the mesh.
struct SubdivisionSize {
  std::uint64_t level_bytes = 0;    ///< all levels of all attributes at the end, uncompressed
  std::uint64_t rounded_bytes = 0;  ///< of rounded attributes: until the commit, so much more
  /// The most that the run adds to the disk, uncompressed; 0 if the backend is not durable.
  std::uint64_t disk_bytes = 0;
  std::uint64_t longest_file_bytes = 0;
  std::uint64_t base_mesh_bytes = 0;  ///< memory while the job makes the base mesh and lays it out
  std::uint64_t memory_bytes = 0;  ///< base mesh, and the part of the budget that the run can use
};

/// The last commit of an earlier run.
struct EarlierRun {
  int level = 0;          ///< the finest level of the positions
  bool normals = false;   ///< the store has normals
  bool finished = false;  ///< the store has everything that the request asks for
};

/// A reason why a job cannot run as it was requested.
struct SubdivisionRefusal {
  /// The option that must change, or that helps (plait/job.h): "backend"; "ignore-size" where
  /// memory or disk are too small, "memory" where the budget is, "force" where the name is taken.
  std::string option;
  ErrorCode code;
  std::string reason;  ///< one line
};

/// The plan of a job. If the job refuses something before it reads the mesh, the members that
/// depend on the mesh are empty.
struct SubdivisionPlan {
  std::vector<SubdivisionRefusal> refusals;  ///< run() throws the first one, as an Error
  std::vector<std::string> warnings;         ///< such as those of read_base_mesh

  /// `budget_bytes` is the request's, less piece_bytes.
  StoreOptions store;
  /// Not 0: the base mesh is one in files (`plait layout`) that is larger than the budget, so that
  /// this part of the budget is for a piece of it at a time.
  std::uint64_t piece_bytes = 0;
  int base_level = 0;  ///< of the store: run() refines the mesh so often in memory
  std::string backend_reason;
  SubdivideOptions subdivide;  ///< without callbacks; the executor is the chosen one
  LayoutKind layout = LayoutKind::kAutomatic;  ///< run() sets the one that it chose
  ComponentType precision = ComponentType::kFloat32;
  bool keeps_store = false;     ///< the backend is durable
  bool commits_levels = false;  ///< so that a later job can resume
  std::optional<EarlierRun> earlier;

  MeshFigures input;
  /// Vertices of borders whose positions others have, and those that the weld merged.
  std::uint64_t seam_vertices = 0, merged_vertices = 0;
  std::vector<LevelCounts> level_counts;  ///< [level], 0 to subdivide.levels
  SubdivisionSize size;
  double import_seconds = 0;
};

/// What a job did.
struct SubdivisionResult {
  SubdivisionPlan plan;         ///< including the additions of run()
  std::filesystem::path store;  ///< empty if the backend is not durable
  /// The open store if the backend is not durable. Otherwise run() has closed the store.
  std::optional<Store> in_memory;
  MeshFigures base;                              ///< the mesh refined base_level times
  int resumed_level = 0;                         ///< the finest level at the start of the run
  std::map<std::string, std::string> pipelines;  ///< of each attribute, by name: Store::pipelines
  std::map<std::string, Rounding> roundings;     ///< of the rounded attributes, by name
  LayoutSpans spans;
  double import_seconds = 0, layout_seconds = 0;
  double refine_seconds = 0;  ///< base mesh and all levels
  double commit_seconds = 0, digest_seconds = 0;
  double prune_seconds = 0;  ///< with `max_distance`, also of the copy
  std::uint64_t stored_bytes = 0;
  /// Memory in addition to the budget: the base mesh, its records, and what
  /// PlannedSubdivision::needs() says.
  std::uint64_t base_mesh_bytes = 0;
  /// With `max_distance`: [finest level] faces, what is drawn, and the largest distance found.
  /// Without, no faces.
  std::vector<std::uint64_t> faces_of_level;
  LevelCounts drawn = {};
  double distance = 0;
  PagingStatistics paging;  ///< until the end of the last commit, of the levels of all faces
  std::string digest;       ///< empty if the request does not ask for it

  /// refine_seconds divided by the number of vertices that the finest level has and the mesh does
  /// not have.
  double ns_per_vertex() const;
};

/// Does not print and does not handle signals. Threads: one at a time (docs/threads.md).
class SubdivisionJob {
 public:
  /// Plans the run. The constructor reads the mesh, opens and locks the store of an earlier run,
  /// and compares the size of the run with the memory and disk space of the machine. It makes no
  /// file that stays, so the program may end at any moment before run(): the precision of a base
  /// mesh that is taken in pieces is found by sorts in files without names. `backends` must outlive
  /// the job. Errors, in addition to plan().refusals: those of read_base_mesh, Store::open and
  /// backends.find; kNotSupported if a backend cannot be used here.
  SubdivisionJob(SubdivisionRequest request, const BackendRegistry& backends);
  SubdivisionJob(SubdivisionJob&&) noexcept;
  SubdivisionJob& operator=(SubdivisionJob&&) noexcept;
  ~SubdivisionJob();

  /// run() adds refusals that it cannot find earlier: a mesh that is not the mesh of the earlier
  /// run, or a budget that is too small for the layout.
  const SubdivisionPlan& plan() const;

  /// Runs the plan, once. Steps: "base mesh" (refine it in memory), "layout", "levels" (counts
  /// vertices; also normals and limit positions), "encode" (counts bytes; attributes that are
  /// rounded or encoded from other blocks), "commit" (with `resume` also after every level),
  /// "digest", "publish". A step's progress starts with 0. After an error only the commits of an
  /// earlier run and of `resume` stay on the disk. It also removes left-overs of killed runs with
  /// the same output. Errors: the first one of plan().refusals, as a JobError; kBudget before it
  /// computes anything; kCancelled; kIo, kNoSpace; those of UnpublishedStore::publish; kBadState if
  /// the job was run before. Pinned by tests/jobs/subdivision_job_test.cpp.
  SubdivisionResult run(const JobWatch& watch = {});

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

PLAIT_END_NAMESPACE
