// plait/kernels/subdivision_job.h: a subdivision from a mesh to a store as one job, which a program
// plans, starts, watches, cancels and resumes. `plait subdivide` is such a program;
// examples/watched_job.cpp is a short one.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "plait/attribute.h"
#include "plait/backend.h"
#include "plait/backend_choice.h"
#include "plait/base_mesh.h"
#include "plait/kernels/subdivide.h"
#include "plait/layout.h"
#include "plait/options.h"
#include "plait/pager.h"
#include "plait/store.h"

namespace plait {

/// What a job does about a store that has the name already.
enum class ExistingStore : std::uint8_t {
  kRefuse,
  kReplace,  ///< the old store goes when the new one is whole, and not before
  /// The job goes on from what is committed in the store, and commits every level under the final
  /// name, so that a job that was interrupted can be resumed by the next one.
  kResume,
};

struct SubdivisionRequest {
  /// A file (PLY, OBJ or OFF, also .gz and .zst) or a mesh.
  std::variant<std::filesystem::path, BaseMesh> mesh;
  /// May be empty where the backend keeps nothing.
  std::filesystem::path store = {};
  int levels = 1;  ///< the level to reach, counted from the mesh

  // An earlier run has decided these already, and a request that resumes it may only repeat them.
  // What is not given is taken from the store, or is the default that is named here.
  std::optional<std::string> backend = {};           ///< what choose_backend says, or "pread"
  std::optional<std::string> codec = {};             ///< that of BackendOptions
  std::optional<std::string> filter = {};            ///< that of BackendOptions
  std::optional<LayoutKind> layout = {};             ///< what suits the executor
  std::optional<Scheme> scheme = {};                 ///< Loop
  std::optional<ComponentType> precision = {};       ///< float32
  std::optional<std::uint64_t> block_bytes = {};     ///< that of StoreOptions
  std::optional<std::uint64_t> max_slot_bytes = {};  ///< 16 KiB; decides the base level

  std::optional<ExecutorKind> executor = {};  ///< fused; sweep with kResume
  std::uint64_t budget_bytes = StoreOptions().budget_bytes;
  int threads = 1;
  bool normals = false;
  bool limit = false;
  /// kNone with kResume: a job that is cancelled may cost the store, since levels that are
  /// committed are overwritten in place.
  Durability durability = Durability::kCommit;
  bool digest = false;       ///< read everything back at the end
  bool ignore_size = false;  ///< begin although memory, disk or budget are too small
  ExistingStore existing = ExistingStore::kRefuse;
  /// Asked for a new store where `backend` is not given; plait/backends/choose_backend.h has one.
  BackendChooser choose_backend = {};
};

struct MeshFigures {
  std::uint64_t vertices = 0, edges = 0, faces = 0, border_edges = 0;
};

/// Estimates from the counts of the mesh, before the mesh is refined in memory.
struct SubdivisionSize {
  std::uint64_t level_bytes = 0;  ///< all levels of all attributes when done, uncompressed
  /// What the run adds to the disk at its widest, uncompressed; 0 where nothing is kept.
  std::uint64_t disk_bytes = 0;
  std::uint64_t longest_file_bytes = 0;
  std::uint64_t base_mesh_bytes = 0;  ///< of memory, while the base mesh is made and laid out
  std::uint64_t memory_bytes = 0;     ///< the base mesh, and what of the budget the run can fill
};

/// What an earlier run left and committed.
struct EarlierRun {
  int level = 0;          ///< that positions have reached
  bool normals = false;   ///< normals of that level are there
  bool finished = false;  ///< nothing of the subdivision is left to do
};

struct SubdivisionRefusal {
  /// The member of SubdivisionRequest that would have to change: "scheme"; "ignore_size" where the
  /// machine has too little.
  std::string_view field;
  ErrorCode code;
  std::string reason;  ///< one line
};

/// What a job is going to do. Where something is refused before the mesh is read, what follows from
/// the mesh is empty.
struct SubdivisionPlan {
  std::vector<SubdivisionRefusal> refusals;  ///< run() throws the first one, as an Error
  std::vector<std::string> warnings;         ///< of reading the mesh, for instance

  StoreOptions store;  ///< `layout` as it was asked for until run() has laid the mesh out
  std::string backend_reason;
  SubdivideOptions subdivide;  ///< without callbacks
  LayoutKind layout = LayoutKind::kAutomatic;
  ComponentType precision = ComponentType::kFloat32;
  bool keeps_store = false;     ///< something is left on the disk
  bool commits_levels = false;  ///< under the final name, for a later job to resume
  std::optional<EarlierRun> earlier;

  MeshFigures input;
  std::vector<LevelCounts> level_counts;  ///< [level], 0 to subdivide.levels
  SubdivisionSize size;
  double import_seconds = 0;
};

enum class SubdivisionStep : std::uint8_t {
  kBaseMesh,  ///< refines the base mesh in memory
  kLayout,    ///< orders it
  kLevels,    ///< makes levels, normals and limit positions
  kCommit,    ///< with kResume after every level
  kDigest,    ///< reads everything back
  kPublish,   ///< gives the store its final name
};
std::string_view to_string(SubdivisionStep step) noexcept;

struct SubdivisionProgress {
  SubdivisionStep step;
  std::string_view phase;     ///< "level 3: odd vertices"; valid during the call
  std::uint64_t done, total;  ///< of the step; of kLevels vertices; the first call of a step has 0
};

/// Both are called by the thread that called run().
struct SubdivisionWatch {
  /// Called at the beginning of every step, and then as work goes on; false cancels the job.
  std::function<bool(const SubdivisionProgress&)> progress = {};
  std::function<void(const std::string&)> warn = {};
};

struct SubdivisionResult {
  SubdivisionPlan plan;         ///< as it was carried out
  std::filesystem::path store;  ///< empty if nothing was kept
  /// The store itself where nothing was kept; closed and not here where it was.
  std::optional<Store> in_memory;
  MeshFigures base;         ///< the mesh refined base_level times
  int resumed_level = 0;    ///< the level that was there when the work began
  bool compressed = false;  ///< whether the store's backend has a codec and a filter
  LayoutSpans spans;
  double import_seconds = 0, layout_seconds = 0;
  double refine_seconds = 0;  ///< the base mesh in memory, and all levels
  double commit_seconds = 0, digest_seconds = 0;
  std::uint64_t stored_bytes = 0;
  /// Memory beside the budget: the base mesh, its records, and what refining keeps.
  std::uint64_t base_mesh_bytes = 0;
  PagingStatistics paging;  ///< up to the end of the last commit
  std::string digest;       ///< empty unless it was asked for

  /// refine_seconds over all vertices made: those of the finest level less those of the mesh.
  double ns_per_vertex() const;
};

/// Prints nothing and handles no signals. One thread at a time.
class SubdivisionJob {
 public:
  /// Plans: reads the mesh, opens the store of an earlier run (and holds its lock from then on),
  /// and compares what the run needs with what the machine has. Makes nothing, so that a process
  /// may end here at any moment. `backends` must outlive the job.
  /// Errors, apart from what plan().refusals tells: those of read_base_mesh, of Store::open, and of
  /// backends.find; kNotSupported of a backend that cannot be had.
  SubdivisionJob(SubdivisionRequest request, const BackendRegistry& backends);
  SubdivisionJob(SubdivisionJob&&) noexcept;
  SubdivisionJob& operator=(SubdivisionJob&&) noexcept;
  ~SubdivisionJob();

  /// What run() refuses after all (the mesh of the earlier run is another one, the budget is too
  /// small for the layout) is added to its refusals.
  const SubdivisionPlan& plan() const;

  /// Does what is planned, once. After an error nothing is left but what an earlier run or
  /// kResume committed, and left-overs of killed runs of the same name are removed in any case.
  /// Errors: of refusals; kBudget before anything is computed; kCancelled; kIo, kNoSpace; those of
  /// PartialStore::publish; kBadState if it is called again.
  /// Pinned by tests/kernels/subdivision_job_test.cpp.
  SubdivisionResult run(const SubdivisionWatch& watch = {});

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace plait
