#include "acceptance/variants.h"

#include <fmt/format.h>

#include <algorithm>

#include "plait/digest.h"
#include "plait/error.h"
#include "plait/extend/sweep.h"
#include "plait/registry.h"
#include "support/temporary_directory.h"
#include "support/usable_backends.h"

namespace plait::test {
namespace {

struct BackendChoice {
  std::string backend, codec;
};

std::vector<BackendChoice> backend_choices() {
  std::vector<BackendChoice> choices;
  for (const std::string& name : usable_backends()) {
    choices.push_back({name, name == "compressed" ? "lz4" : "none"});
    if (name == "compressed") choices.push_back({name, "zstd:1"});
  }
  return choices;
}

constexpr std::uint64_t kLeastBytes = 64 << 10;  ///< the smallest budget of a store
constexpr std::uint64_t kAmpleBytes = std::uint64_t{2} << 30;

Variant make_variant(const BackendChoice& backend, int executor, int threads, int budget, int block,
                     int layout) {
  constexpr ExecutorKind kExecutors[] = {ExecutorKind::kSweep, ExecutorKind::kTransparent,
                                         ExecutorKind::kFused};
  constexpr LayoutKind kLayouts[] = {LayoutKind::kGiven, LayoutKind::kSpatial, LayoutKind::kHilbert,
                                     LayoutKind::kRcm};
  Variant variant;
  variant.backend = backend.backend;
  variant.codec = backend.codec;
  variant.executor = kExecutors[executor];
  variant.threads = 1 + threads % 2;
  variant.budget = budget % 2 == 0 ? BudgetSize::kSmallest : BudgetSize::kAmple;
  variant.block_bytes = std::uint64_t{64} << (block % 2 == 0 ? 10 : 14);
  variant.layout = kLayouts[layout % 4];
  return variant;
}

/// The passes of a Loop subdivision with normals, without their kernels.
std::vector<SweepPass> passes_of(int level, AttributeId position, AttributeId normal) {
  std::vector<SweepPass> passes(3);
  passes[0].accesses = {{position, 1, level - 1, Access::kRead, Reach::kFaces},
                        {position, level, level, Access::kOverwrite}};
  passes[1].accesses = {{position, level, level, Access::kRead, Reach::kFaces},
                        {position, 1, level - 1, Access::kUpdate}};
  passes[2].accesses = {{position, 1, level, Access::kRead, Reach::kFaces},
                        {normal, 1, level, Access::kOverwrite}};
  return passes;
}

}  // namespace

std::string to_string(const Variant& variant) {
  return fmt::format("{} {}, {} on {} threads, {} budget, blocks of {} KiB, layout {}",
                     variant.backend, variant.codec, to_string(variant.executor), variant.threads,
                     variant.budget == BudgetSize::kSmallest ? "smallest" : "ample",
                     variant.block_bytes >> 10, to_string(variant.layout));
}

std::vector<Variant> all_variants() {
  std::vector<Variant> variants;
  for (int factors = 0; factors < 96; ++factors)
    for (const BackendChoice& backend : backend_choices())
      variants.push_back(
          make_variant(backend, factors / 32, factors, factors >> 1, factors >> 2, factors >> 3));
  return variants;
}

std::vector<Variant> covering_variants(int turn) {
  struct Row {
    int executor, threads, budget, block, layout;
  };
  constexpr Row kRows[] = {{2, 0, 1, 0, 2}, {0, 0, 0, 1, 1}, {2, 1, 0, 1, 1},
                           {1, 0, 1, 1, 3}, {1, 1, 0, 0, 2}, {0, 1, 1, 0, 0}};
  std::vector<Variant> variants;
  for (const BackendChoice& backend : backend_choices()) {
    const Row& row = kRows[static_cast<std::size_t>(turn++ % 6)];
    variants.push_back(
        make_variant(backend, row.executor, row.threads, row.budget, row.block, row.layout));
  }
  return variants;
}

Refiner::Refiner(const BaseMesh& mesh, int levels) : levels_(levels) {
  for (const LayoutKind kind :
       {LayoutKind::kGiven, LayoutKind::kSpatial, LayoutKind::kHilbert, LayoutKind::kRcm})
    layouts_.emplace(kind, lay_out(mesh, kind).mesh);
}

StoreOptions Refiner::store_options(const Variant& variant, std::uint64_t budget_bytes) const {
  StoreOptions options;
  options.backend = variant.backend;
  if (variant.backend == "compressed") options.pipeline = "shuffle," + variant.codec;
  options.durability = Durability::kNone;
  options.block_bytes = variant.block_bytes;
  options.budget_bytes = budget_bytes;
  return options;
}

Store Refiner::refine(const Variant& variant, std::uint64_t budget_bytes,
                      const std::filesystem::path& path) const {
  Store store = Store::create(path, mesh(variant.layout), store_options(variant, budget_bytes),
                              default_backends());
  add_base_positions(store);
  SubdivideOptions options;
  options.executor = variant.executor;
  options.threads = variant.threads;
  options.levels = levels_;
  options.normals = true;
  subdivide(store, options);
  store.commit();
  return store;
}

std::string Refiner::digest_under(const Variant& variant, std::uint64_t budget_bytes) const {
  DigestOptions digest_options;
  digest_options.threads = variant.threads;
  if (variant.backend == "memory") {
    Store store = refine(variant, budget_bytes, {});
    return digest(store, digest_options).to_string();
  }
  constexpr std::uint64_t kVertexBytes = 24, kSmallBytes = 256 << 20;
  const std::uint64_t bytes = (mesh(variant.layout).vertex_count() << 2 * levels_) * kVertexBytes;
  const TemporaryDirectory directory(bytes < kSmallBytes ? Medium::kMemory : Medium::kDisk);
  const std::filesystem::path path = directory.path() / "scratch.plait";
  refine(variant, budget_bytes, path).close();
  Store reopened =
      Store::open(path, {.writable = false, .budget_bytes = budget_bytes}, default_backends());
  return digest(reopened, digest_options).to_string();
}

std::string Refiner::digest_of(const Variant& variant) {
  if (variant.budget == BudgetSize::kAmple) return digest_under(variant, kAmpleBytes);
  std::uint64_t& smallest =
      smallest_[{variant.layout, variant.executor, variant.threads, variant.block_bytes}];
  if (variant.executor == ExecutorKind::kSweep) {
    if (smallest == 0) smallest = sweep_budget(variant);
    // Coders take at most a quarter of the budget.
    // Coders, and page buffers on meshes with borders, take up to a quarter of the budget.
    const bool shares =
        default_backends().find(variant.backend).traits.compressed || variant.backend == "uring";
    return digest_under(variant, shares ? smallest + (smallest + 2) / 3 : smallest);
  }
  for (smallest = std::max(smallest, kLeastBytes);; smallest *= 2) {
    try {
      return digest_under(variant, smallest);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kBudget || smallest >= kAmpleBytes) throw;
    }
  }
}

std::uint64_t Refiner::sweep_budget(const Variant& variant) const {
  Variant in_memory = variant;
  in_memory.backend = "memory";
  Store store = Store::create({}, mesh(variant.layout), store_options(in_memory, kAmpleBytes),
                              default_backends());
  const AttributeId position = store.add_attribute(schema_of<Vector3<float>>("position"));
  const AttributeId normal = store.add_attribute(schema_of<Vector3<float>>("normal"));
  std::uint64_t most = kLeastBytes;
  for (int level = 1; level <= levels_; ++level) {
    store.add_level(position);
    store.add_level(normal);
    for (const SweepPass& pass : passes_of(level, position, normal))
      most = std::max(most, sweep_window_bytes(store, pass, variant.threads));
  }
  return most;
}

}  // namespace plait::test
