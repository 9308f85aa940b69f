// job_rules.h: rules that all jobs keep, each in one place.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "plait/base_mesh.h"
#include "plait/compression.h"
#include "plait/extend/backend_registry.h"
#include "plait/extend/rounding.h"
#include "plait/job.h"
#include "plait/layout.h"
#include "plait/options.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Of the option --no-index of all commands that make a store.
inline constexpr std::string_view kNoIndexHelp =
    "Leave out the file base.index: opening the store then computes its base mesh again";

/// Of the option --block of all commands that make a store, and of those that copy one.
inline constexpr std::string_view kBlockHelp =
    "Unit of I/O, a power of two; default 64KiB, or 256KiB with a backend that compresses";
inline constexpr std::string_view kBlockOfCopyHelp =
    "Unit of I/O, a power of two; default: as in the source, or the default of the new backend if "
    "the source has that of its own";

/// Slots of positions are at most this large, unless the user says otherwise: a job takes a finer
/// base mesh until they are.
inline constexpr std::uint64_t kLargestSlotBytes = 16 << 10;

/// The base mesh of a file, whose vertices are welded first if `weld` is set. `merged` counts those
/// that became others. Or that of a directory that `plait layout` has made
/// (layout/base_directory.h): its arrays are read when they are needed.
BaseMesh mesh_of_file(const std::filesystem::path& file, std::optional<double> weld,
                      std::uint64_t& merged, std::vector<std::string>& warnings);

// A mesh in files gives the store that its PLY file gives, with all options.

/// A mesh in files with its faces in the order of the input, in memory; another mesh as it is.
BaseMesh in_input_order(BaseMesh mesh);
/// Whether the mesh is one in files that has the layout already.
bool has_order(const BaseMesh& mesh, LayoutKind kind);
/// As lay_out() of the mesh in_input_order(), which a mesh that has the layout in files needs not.
/// Measures no spans of one that is taken in pieces.
LaidOutMesh laid_out(BaseMesh mesh, LayoutKind kind);

/// What the texts of an option `compress` choose. Errors: as Compression::add().
Compression compression_of(const std::vector<std::string>& texts);
/// Refuses a text for an attribute that a store of a subdivision does not have.
void check_attributes_of_scheme(const Compression& compression, bool normals);
/// Warns of texts of an option `compress` for attributes that a store made of a file does not have.
/// It has `own` and `others`, which are known when the file has been read.
void warn_of_unknown_attributes(const std::vector<std::string>& compress,
                                std::vector<std::string> own,
                                const std::vector<AttributeSchema>& others, const JobWatch& watch);
/// The bounds that the texts of an option `max-error` name. Errors: as ErrorBounds::add().
ErrorBounds error_bounds_of(const std::vector<std::string>& texts);
/// As PipelinesOf. Empty for an empty compression.
PipelinesOf pipelines_of(const Compression& compression);
/// The same, with the rule that a rounding alone implies the default compression: on a backend that
/// compresses, and where the job chooses the backend. `backend` is empty or "auto" there. Errors:
/// those of BackendRegistry::find().
PipelinesOf pipelines_of(const Compression& compression, bool rounds,
                         const std::optional<std::string>& backend,
                         const BackendRegistry& backends);

/// The refusal of a compression on a backend that does not compress. `verb` begins the message.
JobError needs_compression(std::string_view verb, const RegisteredBackend& backend);

/// The refusal of work that needs more memory than the machine has; nothing if it has enough.
/// `what` begins the message: "import mesh.ply: 800 vertices".
std::optional<JobError> lacks_memory(std::string_view what, std::uint64_t needed_bytes);
/// Throws it, unless `ignore`.
void check_memory(std::string_view what, std::uint64_t needed_bytes, bool ignore);

/// What a work says before it sorts in files beside `out`, of which it needs about `needed_bytes`
/// until its end; nothing if that is little. Errors: kNoSpace if less is free. `what` begins the
/// message.
std::optional<std::string> disk_for_sorts(std::string_view what, const std::filesystem::path& out,
                                          std::uint64_t needed_bytes);

/// Warns if a work takes fewer threads than were asked for (0: all processors), because the memory
/// of more does not fit the budget. `what` begins the message. `warn` may be empty.
void warn_of_fewer_threads(std::string_view what, int taken, int asked, std::uint64_t budget_bytes,
                           const std::function<void(const std::string&)>& warn);

PLAIT_END_NAMESPACE
