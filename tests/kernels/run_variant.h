// tests/kernels/run_variant.h: a subdivision under everything that must not change its content.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "plait/digest.h"
#include "plait/extend/session.h"
#include "plait/layout.h"
#include "plait/registry.h"
#include "plait/store.h"
#include "plait/store_info.h"
#include "plait/subdivide.h"
#include "support/temporary_directory.h"

namespace plait::test {

struct Variant {
  std::string backend = "memory";
  std::string codec = "lz4";
  ExecutorKind executor = ExecutorKind::kSweep;
  int threads = 1;
  std::uint64_t budget_bytes = 64 << 20;
  std::uint64_t block_bytes = 1 << 20;
  LayoutKind layout = LayoutKind::kGiven;
  bool double_precision = false;
};

struct Outcome {
  std::string digest;
  PagingStatistics statistics;
};

/// Makes the store, refines, commits, reopens where there is a disk, and leaves nothing.
inline Outcome run(const BaseMesh& base, const SubdivideOptions& what, const Variant& variant) {
  StoreOptions options{.backend = variant.backend};
  if (variant.backend == "compressed") options.pipeline = "shuffle," + variant.codec;
  options.budget_bytes = variant.budget_bytes;
  options.block_bytes = variant.block_bytes;
  options.durability = Durability::kNone;
  // Without a directory where none is needed: to make and remove thousands takes longer than the
  // rest.
  std::optional<TemporaryDirectory> directory;
  std::filesystem::path path;
  if (variant.backend != "memory") path = directory.emplace(Medium::kMemory).path() / "s.plait";
  Store store =
      Store::create(path, lay_out(base, variant.layout).mesh, options, default_backends());
  add_base_positions(store,
                     variant.double_precision ? ComponentType::kFloat64 : ComponentType::kFloat32);
  SubdivideOptions subdivide_options = what;
  subdivide_options.executor = variant.executor;
  subdivide_options.threads = variant.threads;
  subdivide(store, subdivide_options);
  store.commit();
  Outcome outcome;
  outcome.statistics = store.info().paging;
  if (path.empty()) {
    outcome.digest = digest(store).to_string();
    return outcome;
  }
  store.close();
  Store reopened = Store::open(path, {.writable = false, .budget_bytes = variant.budget_bytes},
                               default_backends());
  outcome.digest = digest(reopened, {-1, variant.threads, {}}).to_string();
  return outcome;
}

}  // namespace plait::test
