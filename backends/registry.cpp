#include "plait/backends/registry.h"

#include <utility>

#include "compressed/compressed_backend.h"
#include "memory/memory_backend.h"
#include "mmap/mmap_backend.h"
#include "pread/pread_backend.h"
#include "uring/uring_backend.h"

namespace plait {
namespace {

BackendRegistry built_in() {
  BackendRegistry registry;
  registry.add({"memory", "in memory only, gone with the process", kMemoryTraits,
                open_each_level(open_memory_backend)});
  registry.add({"pread", "raw files, explicit reads and writes; works everywhere", kPreadTraits,
                open_each_level(open_pread_backend)});
  registry.add({"uring", "raw files past the page cache, by io_uring and O_DIRECT (Linux)",
                kUringTraits, open_uring_volume, validate_uring});
  registry.add({"mmap", "raw files, mapped where they are only read", kMmapTraits,
                open_each_level(open_mmap_backend)});
  BackendRegistry::Entry compressed{"compressed", "filter and codec per block (--filter, --codec)",
                                    kCompressedTraits, open_compressed_volume};
  compressed.default_pipeline = "shuffle,zstd:1";
  compressed.validate_pipeline = validate_pipeline;
  registry.add(std::move(compressed));
  return registry;
}

}  // namespace

const BackendRegistry& default_backends() {
  static const BackendRegistry registry = built_in();
  return registry;
}

}  // namespace plait
