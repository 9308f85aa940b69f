// built_in_backends.h: how the registry opens each built-in backend.
#pragma once

#include <memory>
#include <string_view>

#include "plait/extend/backend.h"
#include "plait/extend/backend_registry.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

// Keeps a level in one anonymous mapping. The level ends with the process.

constexpr BackendTraits kMemoryTraits{.in_memory = true};

/// Errors: kOutOfMemory; kBadState unless the mode is kCreate, because no level exists before.
std::unique_ptr<Backend> open_memory_backend(const LevelSpec& level);

// A level as a file of raw bytes, with explicit reads and writes.
// When the pager recycles frames first-in first-out, this is the circular buffer of Guskov's paper.

constexpr BackendTraits kPreadTraits{.durable = true,
                                     .overwrites_in_place = true,
                                     .moves_runs = true,
                                     .in_page_cache = true,
                                     .shares_files = true};

/// The space of a new file is allocated when the file is created. Errors: as open_fixed_file.
std::unique_ptr<Backend> open_pread_backend(const LevelSpec& level);

// A level as a mapped file of raw bytes. The file is the same as with pread, byte for byte.
//
// Only a level that was opened for reading is mapped. For a level that is written, the pager uses
// frames as with pread. Writing through a mapping has three faults. With several threads, half of
// the time goes into TLB shootdowns: the kernel tells every processor that a page may no longer be
// written. A full disk kills the process (SIGBUS). And a stray pointer can change the store.

constexpr BackendTraits kMmapTraits{.durable = true,
                                    .maps_for_reading = true,
                                    .overwrites_in_place = true,
                                    .moves_runs = true,
                                    .in_page_cache = true,
                                    .shares_files = true};

/// Where the file system maps no files, pread stands in, and the volume says so. Errors of levels:
/// as open_fixed_file; kIo if the file cannot be mapped for another reason.
std::unique_ptr<Volume> open_mmap_volume(const VolumeSpec& volume);

// Encodes each block with a pipeline and stores it in an
// extent as long as the result. A level file consists of such extents, in the order in which they
// were written. The block table has their places. The levels of a store share coders.

constexpr BackendTraits kCompressedTraits{
    .durable = true, .compressed = true, .shares_files = true};

/// Errors of a level: as ExtentAllocator and PipelineRegistry::open(); kCorruption for a table
/// entry that its block cannot have; kInvalidArgument if a block is larger than LZ4_MAX_INPUT_SIZE.
RegisteredBackend compressed_backend(const PipelineRegistry& stages);

PLAIT_END_NAMESPACE

PLAIT_BEGIN_NAMESPACE

// A level as a file of raw bytes, which io_uring reads and writes
// past the page cache (O_DIRECT). The file is the same as with pread and mmap, byte for byte.

constexpr BackendTraits kUringTraits{
    .durable = true, .overwrites_in_place = true, .moves_runs = true, .shares_files = true};

/// All levels share one ring, and the page buffers for blocks whose memory is not aligned for
/// O_DIRECT. A new file is preallocated.
/// Where the kernel refuses io_uring, or plait was built without it, pread stands in; where the
/// file system has no O_DIRECT, blocks go through the page cache: TellingVolume::notices() says so.
/// open_level() throws as open_fixed_file does.
std::unique_ptr<Volume> open_uring_volume(const VolumeSpec& volume);

/// Throws kNotSupported if plait was built without liburing, or if the kernel refuses io_uring.
void check_uring();

PLAIT_END_NAMESPACE
