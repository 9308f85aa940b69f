// choose_backend.h: what the backend "auto" is: the rule by which default_backends()
// chooses (BackendRegistry::choose). All raw backends write the same files, byte for byte. The
// choice between them decides only how fast the files are written and read.
//
// The rule, and all of its thresholds, are here. It reads facts and nothing else, so that a test, a
// plan of `plait bench` and `plait info` can ask it about disks that are not there.
#pragma once

#include <cstdint>
#include <string>

#include "plait/detail/namespace.h"
#include "plait/extend/backend_registry.h"

PLAIT_BEGIN_NAMESPACE

/// A store is large if its raw bytes are more than 1/kLargeStoreDivisor of the available memory.
/// The page cache keeps a smaller one for its next reader, and random patches come out of it in
/// seven tenths of the time; a larger one is read and written faster past the page cache.
/// docs/backends.md has the measurement.
inline constexpr std::uint64_t kLargeStoreDivisor = 2;

/// What a file system keeps its files on. A disk that rotates has no name here: virtual disks say
/// that they rotate, and no measurement shows another choice for one that does.
enum class StoreMedium : std::uint8_t {
  kUnknown,  ///< the system gives no answer
  kMemory,   ///< tmpfs or ramfs
  kNetwork,  ///< another machine, or another program (NFS, SMB, 9P, FUSE, ...)
  kDisk,     ///< everything else
};

/// What the rule is decided by.
struct BackendFacts {
  std::uint64_t level_bytes = 0;      ///< of the store's levels, before compression
  std::uint64_t available_bytes = 0;  ///< of memory
  StoreMedium medium = StoreMedium::kUnknown;
  std::string no_mmap = {};    ///< why there is no backend that maps; empty if there is one
  std::string no_uring = {};   ///< why the kernel refuses io_uring; empty if it does not
  std::string no_direct = {};  ///< why the file system refuses O_DIRECT; empty if it does not
  bool in_memory = false;      ///< the store has no path
  bool has_pipelines = false;  ///< the caller names pipelines
};

/// The rule. The first line that is true decides:
///
/// 1. The store has no path: memory.
/// 2. The caller names pipelines: compressed.
/// 3. The files are in memory: mmap, because there they are read without a copy. No disk can fail
///    under the mapping, which would be a signal (SIGBUS). Without such a backend: pread.
/// 4. The files are on another machine, or on a medium that is not known: pread.
/// 5. The store is small compared with the memory, or its size is not known: pread, which leaves it
///    in the page cache. A mapping would read it faster, but a disk can fail under it.
/// 6. The kernel refuses io_uring, or the file system O_DIRECT: pread.
/// 7. uring.
///
/// The reason has the sizes. Pinned by tests/backends/choose_backend_test.cpp.
BackendChoice choose_backend(const BackendFacts& facts);

/// The facts about a new store, which need not exist, but its directory must. Never fails: what
/// cannot be found out counts in favour of pread.
BackendFacts backend_facts(const BackendRegistry& backends, const NewStore& store);

/// The rule applied to the facts of this machine.
BackendChoice choose_backend(const BackendRegistry& backends, const NewStore& store);

PLAIT_END_NAMESPACE
