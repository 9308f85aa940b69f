#include "plait/registry.h"

#include "built_in_backends.h"
#include "choose_backend.h"
#include "plait/create_store.h"
#include "plait/layout.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

BackendRegistry default_backends(const PipelineRegistry& pipelines) {
  BackendRegistry registry;
  registry.add({"memory", "in memory only; ends with the process", kMemoryTraits,
                open_each_level(open_memory_backend)});
  registry.add({"pread", "raw files, explicit reads and writes; works everywhere", kPreadTraits,
                open_each_level(open_pread_backend)});
  registry.add({"uring", "raw files past the page cache, by io_uring and O_DIRECT (Linux)",
                kUringTraits, open_uring_volume});
  registry.add(
      {"mmap", "raw files, mapped when they are only read", kMmapTraits, open_mmap_volume});
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

Store create_store(const std::filesystem::path& path, const BaseMesh& mesh,
                   const StoreOptions& options) {
  Store store =
      Store::create(path, lay_out(mesh, LayoutKind::kAutomatic), options, default_backends());
  add_base_positions(store);
  return store;
}

Store open_store(const std::filesystem::path& path, const OpenOptions& options) {
  return Store::open(path, options, default_backends());
}

PLAIT_END_NAMESPACE
