// tests/acceptance/variants.h: one struct with all choices that must not change a store's content.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "plait/base_mesh.h"
#include "plait/layout.h"
#include "plait/store.h"
#include "plait/subdivide.h"

namespace plait::test {

enum class BudgetSize { kSmallest, kAmple };

struct Variant {
  std::string backend = "memory";
  std::string codec = "none";
  ExecutorKind executor = ExecutorKind::kSweep;
  int threads = 2;
  BudgetSize budget = BudgetSize::kAmple;
  std::uint64_t block_bytes = 1 << 20;
  LayoutKind layout = LayoutKind::kSpatial;
};
std::string to_string(const Variant& variant);

/// All combinations: the backends that this machine can use (compressed with two codecs) x 3
/// executors x 2 thread counts x 2 budgets x 2 block sizes x 4 layouts. The backend changes
/// fastest.
std::vector<Variant> all_variants();

/// The variants for mesh number `turn`, one per backend and codec. Six turns in a row combine each
/// backend with every value of every other factor. They also combine every two values of any two
/// factors other than the layout.
std::vector<Variant> covering_variants(int turn);

/// Refines one mesh with normals, in all layouts.
class Refiner {
 public:
  Refiner(const BaseMesh& mesh, int levels);

  int levels() const { return levels_; }
  const BaseMesh& mesh(LayoutKind layout) const { return layouts_.at(layout); }

  /// Makes the store in a temporary directory, commits and reopens it, and returns the digest. With
  /// the sweep executor, BudgetSize::kSmallest is the exact minimum, plus the share of coders and
  /// of page buffers. With another executor it is the smallest sufficient power of two.
  std::string digest_of(const Variant& variant);

  /// The bytes of the frames that the widest pass of the sweep executor pins at the same time,
  /// which is the smallest possible budget.
  std::uint64_t sweep_budget(const Variant& variant) const;

  /// A new refined and committed store with the budget `budget_bytes`. An empty `path` means a
  /// store in memory.
  Store refine(const Variant& variant, std::uint64_t budget_bytes,
               const std::filesystem::path& path) const;

 private:
  StoreOptions store_options(const Variant& variant, std::uint64_t budget_bytes) const;
  std::string digest_under(const Variant& variant, std::uint64_t budget_bytes) const;

  int levels_;
  std::map<LayoutKind, BaseMesh> layouts_;
  /// The backend is no part of the key, because frames count in the same way for all backends.
  std::map<std::tuple<LayoutKind, ExecutorKind, int, std::uint64_t>, std::uint64_t> smallest_;
};

}  // namespace plait::test
