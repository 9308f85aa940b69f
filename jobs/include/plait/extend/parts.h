// plait/extend/parts.h: a store that many processes make, on one machine or on many. They need a
// directory that all of them see, and do not talk to each other: `plait plan`, `plait part` and
// `plait join` are programs for these functions. Pinned by tests/jobs/parts_test.cpp.
//
// The plan is a directory: the base mesh in layout order, the options, and where the edges are cut
// into parts. Each part computes its range of edges from the base mesh alone, with the faces on the
// other side of the cuts (ghosts), and so gives the same bits as a run of one process. Its files
// are in a directory of its own until they are complete; then the file done.I appears in one step.
// So a part that is killed, started twice or started by two machines at once does no harm.
//
// plan_pass() plans a pass over a store in shards, as join_parts() has made it. Each part reads the
// last commit, also what other shards have at its cuts, and makes the attribute's shard of the next
// version; join_parts() commits this version. For n iterations make n plans, one after another.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "plait/attribute.h"
#include "plait/detail/namespace.h"
#include "plait/existing.h"
#include "plait/extend/backend_registry.h"
#include "plait/extend/pass.h"
#include "plait/layout.h"
#include "plait/options.h"
#include "plait/progress.h"
#include "plait/store.h"
#include "plait/subdivide.h"

PLAIT_BEGIN_NAMESPACE

/// What plan_parts() plans. Members that a SubdivisionRequest has too mean the same.
struct PartsRequest {
  std::filesystem::path mesh;
  std::filesystem::path plan;  ///< the directory to make
  std::uint32_t parts = 1;     ///< at most one for each edge of the base mesh
  int levels = 1;
  Scheme scheme = {};  ///< of the library
  std::optional<ComponentType> precision = {};
  std::optional<double> weld = {};
  LayoutKind layout = LayoutKind::kHilbert;
  bool normals = false;
  bool limit = false;
  std::uint64_t block_bytes = 0;  ///< as in StoreOptions
  std::optional<std::uint64_t> max_slot_bytes = {};
  /// Pipelines whose blocks need no other blocks. Empty: raw blocks.
  PipelinesOf pipeline_of = {};
  /// Measures this machine for about two seconds by small parts that are removed again. The seconds
  /// of parts are then those of this machine; all other figures and the cuts stay.
  bool calibrate = false;
  /// For a base mesh in files (`plait layout`), beside the program: a larger one is read by ranges,
  /// in so much memory, and sorted in temporary files beside the plan.
  std::uint64_t memory_bytes = std::uint64_t{2} << 30;
  /// Called before the first file is made. May throw: then there is no plan.
  std::function<void()> before_files = {};
  /// Of the steps and of the measurement; if it returns false, there is no plan.
  ProgressCallback progress = {};
};

/// What a machine does in one thread, as measured.
struct MachineRates {
  double points_per_second = 0;  ///< vertices of refined faces; one counts in each of its faces
  double bytes_per_second = 0;   ///< written to the plan's file system and synced
  double begin_seconds = 0;      ///< that each part takes whatever its size, e.g. for the base mesh
};

/// One part of a plan. Seconds are an estimate for one thread.
struct PlannedPart {
  EdgeId first_edge = 0, edge_after = 0;
  std::uint64_t records = 0;  ///< of each attribute that it makes, in the levels
  std::uint64_t faces = 0;    ///< that it refines, or reads
  std::uint64_t ghosts = 0;   ///< faces among them that another part refines or reads too
  std::uint64_t bytes = 0;    ///< of the levels that it makes, uncompressed
  double seconds = 0;
};

/// The pass that a plan cuts.
struct PlannedPass {
  std::filesystem::path store;  ///< absolute
  std::uint64_t version = 0;    ///< Store::sequence() of the commit that the parts read
  /// Of the file version.S of this commit: copies of a store that went different ways have other
  /// ones.
  std::uint64_t version_checksum = 0;
  Pass pass;               ///< without a kernel
  AttributeSchema result;  ///< the attribute that it makes
};

/// What a part with most bytes needs in one thread, so what to ask a scheduler for.
struct PartMemory {
  std::uint64_t budget_bytes = 0;  ///< PartOptions::budget_bytes: scratch memory and blocks
  std::uint64_t total_bytes = 0;   ///< with the base mesh and the program, an estimate
};

/// What a plan says.
struct PartsPlan {
  StoreUuid uuid{};  ///< of the store
  std::string program;
  int levels = 0, base_level = 0;
  std::uint64_t vertices = 0;  ///< of the finest level
  std::string backend;
  std::uint64_t files = 0;  ///< that the joined store has
  std::vector<PlannedPart> parts;
  std::uint64_t merged_vertices = 0;  ///< by the weld; only from plan_parts()
  std::vector<std::string> warnings;  ///< of the mesh; only from plan_parts()
  std::optional<MachineRates> rates;  ///< only from plan_parts() with `calibrate`
  std::optional<PartMemory> memory;   ///< only of a subdivision, from the functions that plan it
  std::optional<PlannedPass> pass;    ///< nothing: a subdivision
};

/// What plan_pass() plans.
struct PassRequest {
  std::filesystem::path store;  ///< in shards
  std::filesystem::path plan;   ///< the directory to make
  Pass pass;                    ///< its kernel is not called
  std::uint64_t budget_bytes = StoreOptions().budget_bytes;
  int threads = 1;  ///< that measure the diagonal for noise, if the pass does not name it
  std::function<void()> before_files = {};  ///< as in PartsRequest
  ProgressCallback progress = {};           ///< of measuring the diagonal
};

/// Plans one pass over the last commit of a store. The parts are its shards. Errors:
/// kInvalidArgument for a pass that does not fit the store, and if the name is taken; kNotSupported
/// for a store whose levels are in one piece, and if the result's pipelines need other blocks;
/// those of Store::open() and visit_vertices(); kIo, kNoSpace.
PartsPlan plan_pass(const PassRequest& request, const BackendRegistry& backends);

/// Makes the directory `request.plan`. A plan never changes. Errors: kInvalidArgument for more
/// parts than edges, a block size that no store can have, and if the name is taken; kNotSupported
/// for a rule of a program's own, limit positions of a scheme without them, more than
/// kMostFusedLevels levels over the base mesh, and pipelines whose blocks need other blocks; those
/// of reading the mesh; those of make_part() if it measures; kIo, kNoSpace.
PartsPlan plan_parts(const PartsRequest& request, const BackendRegistry& backends);

/// Makes a plan of a store in shards again, with its UUID and its cuts: so a part of it can be made
/// again, and join_parts() into the store mends the shard. Passes may have added attributes since.
/// Errors: kNotSupported if the store is in one piece, if a pass has replaced the positions, and if
/// another version of plait made the parts; kInvalidArgument if the name `plan` is taken;
/// kNotFound, kCorruption, kIo, kNoSpace. `before_files`: as in PartsRequest.
PartsPlan plan_again(const std::filesystem::path& store, const std::filesystem::path& plan,
                     const BackendRegistry& backends,
                     const std::function<void()>& before_files = {});

/// Errors: kNotFound, kCorruption, kIo.
PartsPlan read_parts_plan(const std::filesystem::path& plan);

/// Options of make_part().
struct PartOptions {
  std::uint64_t budget_bytes = StoreOptions().budget_bytes;
  int threads = 1;                ///< 0: all processors
  ParallelFor parallel_for = {};  ///< as in StoreOptions
  bool again = false;             ///< makes the part even if it is done
  /// Is told if the scratch memory of all threads does not fit the budget, so that a subdivision
  /// takes fewer.
  std::function<void(const std::string&)> warn = {};
  ProgressCallback progress = {};
  /// The kernel of the plan's pass, if that is one of the program's own.
  PassKernel kernel = {};
  /// Where this machine sees the store that the plan's pass reads. Empty: at PlannedPass::store.
  std::filesystem::path store = {};
};

/// What make_part() did.
struct PartResult {
  bool was_done = false;  ///< the part was complete before: nothing was computed
  std::string digest;     ///< of the part's records; the sum of all parts is that of the store
  std::uint64_t bytes = 0;
  double seconds = 0;
};

/// Makes one part. Writes only into a directory part.I-... of the plan, and at the end gives done.I
/// its name. Errors: kInvalidArgument for a part that the plan does not have; kNotSupported if
/// another version of plait made the plan; kCorruption for a damaged plan; kCancelled; kBudget,
/// kIo, kNoSpace. For a pass also: kBadState if the store has another version than the plan, or is
/// another store or a copy that went its own way; kInvalidArgument for a pass of another program
/// without `options.kernel`, and for `options.store` without a pass; those of Store::open(),
/// visit_vertices() and the kernel.
PartResult make_part(const std::filesystem::path& plan, std::uint32_t part,
                     const PartOptions& options, const BackendRegistry& backends);

/// One part of a plan, as its directory shows it.
struct PartStatus {
  enum class State : std::uint8_t {
    kWaiting,  ///< nobody has begun it
    kRunning,  ///< a process of this machine makes it; or one of another machine, if that still
               ///< runs
    kLost,     ///< the process of this machine that made it has ended without a result
    kDone,
  };
  State state = State::kWaiting;
  std::string host = {};    ///< that makes or made it
  std::string user = {};    ///< that made it
  std::uint64_t begun = 0;  ///< seconds since 1970, UTC; 0 unless running, lost or done
  /// When its files changed last, of a running part; then it may be clear that its machine is lost.
  std::uint64_t changed = 0;
  double seconds = 0, cpu_seconds = 0;  ///< that it took, if done
  std::uint64_t peak_memory_bytes = 0;  ///< of the process that made it
};

/// How far a plan is.
struct PlanStatus {
  std::vector<PartStatus> parts;
  std::uint32_t done = 0, running = 0, lost = 0, waiting = 0;
  std::uint64_t bytes_done = 0;  ///< of the levels of done parts, uncompressed
  /// Of one process: bytes of done parts by their seconds. 0 if none is done.
  double bytes_per_second = 0;
  /// Until all parts are done, if as many processes as now go on, at least one; by the seconds that
  /// done parts took, compared with those that were planned. Nothing if none is done.
  std::optional<double> seconds_left;
};

/// Looks at the names in a plan and at done.I of done parts, not at their other files, and changes
/// nothing. Errors: kNotFound, kCorruption, kIo.
PlanStatus status_of_plan(const std::filesystem::path& plan);

/// Options of join_parts().
struct JoinOptions {
  /// Reads every block first, and compares the digests; of a store that was joined before, reads
  /// every block of the store.
  bool verify = false;
  bool concat = false;                    ///< makes levels in one piece, which copies all bytes
  Existing existing = Existing::kRefuse;  ///< whether the store may replace a store
  std::uint64_t budget_bytes = StoreOptions().budget_bytes;
  ProgressCallback progress = {};
  std::function<void(const std::string&)> warn = {};
};

/// What join_parts() did, or which parts stopped it.
struct JoinResult {
  std::vector<std::uint32_t> missing, bad;  ///< ascending
  std::vector<std::string> reasons;         ///< one line for each of `bad`
  bool has_store = false;                   ///< nothing was missing or bad: the store is made
  bool was_joined = false;                  ///< an earlier join had made it
  /// The sum of the digests of the parts. If only a few parts of a store that was joined before are
  /// there, that of the store with `verify`, else empty.
  std::string digest;
  std::uint64_t version = 0;  ///< Store::sequence() of the store
  /// Both lists together, as array_text().
  std::string again() const;
};

/// Makes `store` of all parts. The files of the parts get a second name there (hard links); where
/// that cannot be, they are copied. The plan stays as it is. After an error no store is left. If
/// `store` is the one that an earlier call has made of this plan, also if passes have changed it
/// since, the call changes nothing, but mends it: then not all parts must be there, and files of
/// those that were made after the store replace files with other bytes. They do so only if the
/// store records the checksums of their blocks. kBadState for a part with other blocks; kBusy while
/// readers have a store open that is to be mended.
/// Errors: those of UnpublishedStore; kCorruption for a damaged plan, and with
/// `verify` for a store that is damaged; kCancelled; kIo, kNoSpace.
///
/// The parts of a pass become the next version of `store`, which is the store of the plan. One
/// manifest commits it; readers keep their version. After an error the store has its version. The
/// digest is that of the records of the attribute that the pass makes. If the store has the version
/// of this very plan already, the call does nothing. Errors: kBadState for another store, for
/// another version, and for a copy that went its own way; kBusy while another process changes the
/// store; kInvalidArgument for `concat` and kReplace; those of Store::open().
JoinResult join_parts(const std::filesystem::path& plan, const std::filesystem::path& store,
                      const JoinOptions& options, const BackendRegistry& backends);

/// "3,17-19": ascending numbers as array jobs take them.
std::string array_text(std::span<const std::uint32_t> numbers);

PLAIT_END_NAMESPACE
