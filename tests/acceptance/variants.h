// tests/acceptance/variants.h: everything that must not change a store's content, as one struct.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "plait/base_mesh.h"
#include "plait/kernels/subdivide.h"
#include "plait/layout.h"
#include "plait/store.h"

namespace plait::test {

enum class Budget { kSmallest, kAmple };

struct Variant {
  std::string backend = "memory";
  std::string codec = "none";
  ExecutorKind executor = ExecutorKind::kSweep;
  int threads = 2;
  Budget budget = Budget::kAmple;
  std::uint64_t block_bytes = 1 << 20;
  LayoutKind layout = LayoutKind::kSpatial;
};
std::string to_string(const Variant& variant);

/// The full product: all backends that this machine has, compressed with two codecs, x 3 executors
/// x 2 thread counts x 2 budgets x 2 block sizes x 4 layouts. The backend changes fastest.
std::vector<Variant> all_variants();

/// Those for the `turn`-th mesh, one a backend and codec. Six turns in a row bring each backend
/// together with every value of every other factor, and every two values of two factors other than
/// the layout.
std::vector<Variant> covering_variants(int turn);

/// One mesh in all layouts, refined with normals as often as asked for.
class Refiner {
 public:
  Refiner(const BaseMesh& mesh, int levels);

  int levels() const { return levels_; }
  const BaseMesh& mesh(LayoutKind layout) const { return layouts_.at(layout); }

  /// Makes the store in a scratch directory, commits, reopens, returns the digest, leaves nothing.
  /// The smallest budget is exact for sweep where no blocks are coded, and for the others the first
  /// power of two that does.
  std::string digest_of(const Variant& variant);

  /// Frames that the widest pass of the sweep executor pins at once: nothing less will do.
  std::uint64_t sweep_budget(const Variant& variant) const;

  /// A new refined store under `budget_bytes`, committed. Empty `path`: only in memory.
  Store refine(const Variant& variant, std::uint64_t budget_bytes,
               const std::filesystem::path& path) const;

 private:
  StoreOptions store_options(const Variant& variant, std::uint64_t budget_bytes) const;
  std::string digest_under(const Variant& variant, std::uint64_t budget_bytes) const;

  int levels_;
  std::map<LayoutKind, BaseMesh> layouts_;
  /// The backend does not enter: frames are counted alike for all of them.
  std::map<std::tuple<LayoutKind, ExecutorKind, int, std::uint64_t>, std::uint64_t> smallest_;
};

}  // namespace plait::test
