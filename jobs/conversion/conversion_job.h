// conversion/conversion_job.h: one job that copies a store into another backend, compression or
// block size. `plait convert` is a program for it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>

#include "plait/compression.h"
#include "plait/detail/namespace.h"
#include "plait/existing.h"
#include "plait/extend/backend_registry.h"
#include "plait/extend/block_table.h"
#include "plait/extend/rounding.h"
#include "plait/job.h"
#include "plait/options.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

/// What a job shall copy. The copy is like the source in everything that no member changes.
struct ConversionRequest {
  std::filesystem::path from, to;
  /// Empty: that of the source, or "compressed" for a compression or rounding that it cannot do.
  /// "auto": chosen by the size (BackendRegistry::choose).
  std::string backend = {};
  Compression compression = {};  ///< empty: as in the source
  /// Attributes that are rounded (plait/extend/rounding.h).
  ErrorBounds max_errors = {};
  std::uint64_t block_bytes = 0;  ///< 0: as in the source
  bool no_index = false;          ///< no file base.index (StoreOptions::base_index)
  /// The two stores share it.
  std::uint64_t budget_bytes = StoreOptions().budget_bytes;
  int threads = 1;                ///< of `verify`
  ParallelFor parallel_for = {};  ///< as in StoreOptions
  bool verify = false;  ///< reads the copy back from the disk, and compares it with the source
  /// Called before anything is copied: gives the base mesh of the copy, which is that of the source
  /// with other depths. Empty: that of the source.
  std::function<BaseMesh(Store& source)> base = {};
  /// Called before the commit: changes the copy, whose levels are all there. Not with `verify`.
  std::function<void(Store& copy)> change = {};
  std::vector<std::string> attributes_of_change = {};  ///< names of those that it may add
  /// Called after the commit with the path of the copy, which does not have its name yet: adds
  /// optional files. After an error no copy is left.
  std::function<void(const std::filesystem::path& copy)> finish = {};
  /// Each face gets all levels; those that it did not have are filled
  /// (conversion/uniform_levels.h). Then `verify` compares the records that the source has. Not
  /// with `max_errors` or `change`.
  bool uniform = false;
  const char* verb = "convert";           ///< begins messages
  std::optional<StoreUuid> uuid = {};     ///< of the copy; nothing: a new one
  Existing existing = Existing::kRefuse;  ///< whether the copy may replace a store
};

/// What a job did.
struct ConversionResult {
  std::filesystem::path store;
  StoreOptions options;
  std::string backend_reason;
  std::string from_backend;  ///< of the source
  std::uint64_t from_stored_bytes = 0, stored_bytes = 0;
  std::uint64_t vertices = 0;                 ///< of the copy, of all levels
  std::uint64_t filled_vertices = 0;          ///< with `uniform`, those that the source lacks
  std::map<std::string, Rounding> roundings;  ///< of the rounded attributes, by name
  /// Those that the source records and the copy does not, because its filled vertices are not
  /// rounded.
  std::map<std::string, Rounding> left_out_roundings;
  std::string digest;  ///< with `verify`, of the copy
};

/// Vertices of all levels, as the store's depths leave them.
std::uint64_t vertices_of(const Store& store);

/// Copies a store. After an error no copy is left. Removes left-overs of killed runs with the same
/// output. Does not print and does not handle signals. `source_backends` open the source,
/// `backends` make the copy. Steps, which are the phases too: "convert" (counts bytes; patches
/// where levels are filled, and then "encode"), "read the copy back" (the digest of the copy, or a
/// comparison of rounded records, or of those of the source), "digest of the source" (after
/// rounding, of the copy; after filling, "digest of the copy"), "publish". Errors: those of
/// Store::open and Store::create; kInvalidArgument if source and copy are the same, for a backend
/// that writes no files, for a compression that the backend does not do, and for `uniform` with
/// `max_errors`; kCancelled; kCorruption if the copy is not equal; kIo, kNoSpace. Pinned by
/// tests/tools/store_commands_test.cpp and tests/jobs/uniform_levels_test.cpp.
ConversionResult convert(const ConversionRequest& request, const BackendRegistry& source_backends,
                         const BackendRegistry& backends, const JobWatch& watch = {});

PLAIT_END_NAMESPACE
