// Rounding modes and flush-to-zero of a program's threads change no record, and are as before after
// each call.
#include <array>
#include <catch2/catch.hpp>
#include <cfenv>
#include <string>
#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

#include "plait/digest.h"
#include "plait/layout.h"
#include "plait/registry.h"
#include "plait/subdivide.h"
#include "plait/visit_vertices.h"
#include "support/sanitized.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

constexpr int kFinestLevel = unless_sanitized(4, 3);

/// Changes the arithmetic of the calling thread until it is destroyed.
class OddArithmetic {
 public:
  explicit OddArithmetic(int rounding) {
    std::fegetenv(&former_);
    std::fesetround(rounding);
#if defined(__x86_64__)
    _mm_setcsr(_mm_getcsr() | 0x8040);  // flush results to zero, take denormals as zero
    set_ = _mm_getcsr() & ~0x3fu;       // without the sticky bits of exceptions
#endif
  }
  ~OddArithmetic() { std::fesetenv(&former_); }
  OddArithmetic(const OddArithmetic&) = delete;
  OddArithmetic& operator=(const OddArithmetic&) = delete;
  bool is_still_set() const {
#if defined(__x86_64__)
    if ((_mm_getcsr() & ~0x3fu) != set_) return false;
#endif
    return std::fegetround() != FE_TONEAREST;
  }

 private:
  std::fenv_t former_;
  unsigned set_ = 0;
};

/// Positions whose differences are no normal float32 numbers.
IndexedMesh tiny() {
  IndexedMesh mesh = random_sheet(5, 60);
  for (auto& position : mesh.positions) position = 1.7e-39 * position;
  return mesh;
}

struct Way {
  std::string backend, pipeline;
  ExecutorKind executor;
  int threads, base_level;
};

std::string digest_of(const IndexedMesh& mesh, const Way& way) {
  const TemporaryDirectory directory;
  StoreOptions options{
      .backend = way.backend, .durability = Durability::kNone, .block_bytes = 4096};
  if (!way.pipeline.empty()) options.pipeline = way.pipeline;
  BaseMesh base = BaseMesh::build(mesh);
  if (way.base_level > 0) base = rebase(base, way.base_level, Scheme());
  const auto path =
      way.backend == "memory" ? std::filesystem::path() : directory.path() / "s.plait";
  Store store = Store::create(path, lay_out(base, LayoutKind::kAutomatic), options,
                              default_backends(), {.base_level = way.base_level});
  add_base_positions(store);
  subdivide(store, {.executor = way.executor,
                    .levels = kFinestLevel,
                    .normals = true,
                    .limit = way.executor == ExecutorKind::kSweep,
                    .threads = way.threads});
  using Point = Vector3<float>;
  store.add_attribute(schema_of<Point>("smooth"), kFinestLevel);
  visit_vertices(
      store, {.threads = way.threads},
      std::tuple{rings_of<Point>("position"), overwrites<Point>("smooth")},
      [](const VertexRun& run, const VertexRings<Point>& position, std::span<Point> smooth) {
        for (std::size_t i = 0; i < run.count; ++i) {
          Point sum{};
          for (int k = 0; k < position.valence(); ++k) sum = sum + 0.3f * position.neighbour(i, k);
          smooth[i] = sum;
        }
      });
  store.commit();
  return digest(store, {.threads = way.threads}).to_string();
}

}  // namespace

TEST_CASE("Digest_InThreadsWithOddArithmetic_IsTheSame") {
  const Way ways[] = {{"memory", "", ExecutorKind::kFused, 1, 0},
                      {"memory", "", ExecutorKind::kFused, 2, 1},
                      {"memory", "", ExecutorKind::kSweep, 1, 0},
                      {"memory", "", ExecutorKind::kSweep, 2, 0},
                      {"memory", "", ExecutorKind::kTransparent, 1, 0},
                      {"pread", "", ExecutorKind::kFused, 0, 0},
                      {"compressed", "shuffle,zstd:1", ExecutorKind::kSweep, 2, 0},
                      {"compressed", "predicted,zstd:1", ExecutorKind::kFused, 2, 0}};
  for (const IndexedMesh& mesh : {random_sheet(5, 60), tiny()})
    for (const Way& way : ways) {
      CAPTURE(way.backend, way.pipeline, to_string(way.executor), way.threads);
      const std::string expected = digest_of(mesh, way);
      for (const int rounding : {FE_UPWARD, FE_TOWARDZERO}) {
        const OddArithmetic odd(rounding);
        const std::string found = digest_of(mesh, way);
        CHECK(odd.is_still_set());
        CHECK(found == expected);
      }
    }
}

TEST_CASE("Threads_Zero_AreAllProcessors") {
  const IndexedMesh mesh = random_sheet(5, 60);
  for (const ExecutorKind executor :
       {ExecutorKind::kFused, ExecutorKind::kSweep, ExecutorKind::kTransparent})
    CHECK(digest_of(mesh, {"memory", "", executor, 0, 0}) ==
          digest_of(mesh, {"memory", "", executor, 1, 0}));
  for (const int wrong : {-1, 1025}) {
    Store store =
        Store::create({}, BaseMesh::build(mesh), {.backend = "memory"}, default_backends());
    add_base_positions(store);
    CHECK_THROWS_WITH(subdivide(store, {.levels = 2, .threads = wrong}),
                      Catch::Contains("or 0 for all processors"));
    CHECK_THROWS_WITH(digest(store, {.threads = wrong}),
                      Catch::Contains("or 0 for all processors"));
  }
}
