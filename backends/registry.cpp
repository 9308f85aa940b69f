#include "plait/registry.h"

#include "choose_backend.h"
#include "compressed/compressed_backend.h"
#include "memory/memory_backend.h"
#include "mmap/mmap_backend.h"
#include "pread/pread_backend.h"
#include "uring/uring_backend.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

BackendRegistry default_backends(const PipelineRegistry& pipelines) {
  BackendRegistry registry;
  registry.add({"memory", "in memory only; ends with the process", kMemoryTraits,
                open_each_level(open_memory_backend)});
  registry.add({"pread", "raw files, explicit reads and writes; works everywhere", kPreadTraits,
                open_each_level(open_pread_backend)});
  registry.add({"uring", "raw files past the page cache, by io_uring and O_DIRECT (Linux)",
                kUringTraits, open_uring_volume});
  registry.add({"mmap", "raw files, mapped when they are only read", kMmapTraits,
                open_each_level(open_mmap_backend)});
  registry.add(compressed_backend(pipelines));
  registry.set_chooser([](const BackendRegistry& backends, const NewStore& store) {
    return choose_backend(backends, store);
  });
  return registry;
}

const BackendRegistry& default_backends() {
  static const BackendRegistry registry = default_backends(default_pipelines());
  return registry;
}

PLAIT_END_NAMESPACE
