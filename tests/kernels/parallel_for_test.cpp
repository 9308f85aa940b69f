// Subdivisions and visits on threads of the program give the same bits, whatever its pool does.
#include <catch2/catch.hpp>
#include <string>

#include "plait/digest.h"
#include "plait/layout.h"
#include "plait/registry.h"
#include "plait/subdivide.h"
#include "plait/visit_vertices.h"
#include "support/parallel_loops.h"
#include "support/sanitized.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

using PoolPoint = Vector3<float>;

/// The digest of a surface that was subdivided and then visited by `threads` workers.
std::string digest_of_work(const BaseMesh& base, const ParallelFor& loop, ExecutorKind executor,
                           int threads) {
  const TemporaryDirectory directory(Medium::kMemory);
  const StoreOptions options{.backend = "pread",
                             .durability = Durability::kNone,
                             .block_bytes = 64 << 10,
                             .parallel_for = loop};
  const auto path = directory.path() / "s.plait";
  {
    Store store = Store::create(path, base, options, default_backends());
    add_base_positions(store);
    subdivide(store, {.executor = executor, .levels = 5, .normals = true, .threads = threads});
    store.commit();
  }
  const OpenOptions opening{
      .writable = true, .durability = Durability::kNone, .parallel_for = loop};
  Store store = Store::open(path, opening, default_backends());
  store.add_attribute(schema_of<PoolPoint>("smooth"), 5);
  visit_vertices(store, {.threads = threads},
                 std::tuple{rings_of<PoolPoint>("position"), overwrites<PoolPoint>("smooth")},
                 [](const VertexRun&, const VertexRings<PoolPoint>& at, std::span<PoolPoint> to) {
                   for (std::size_t i = 0; i < to.size(); ++i) {
                     PoolPoint sum{};
                     for (int k = 0; k < at.valence(); ++k) sum = sum + at.neighbour(i, k);
                     to[i] = sum;
                   }
                 });
  return digest(store, {.threads = threads}).to_string();
}

}  // namespace

TEST_CASE("SubdivideAndVisit_OnThePoolOfTheProgram_GiveTheSameBits") {
  const BaseMesh base =
      lay_out(BaseMesh::build(random_sphere(8, unless_sanitized(200u, 40u))), LayoutKind::kHilbert)
          .mesh;
  const std::string expected = digest_of_work(base, {}, ExecutorKind::kSweep, 1);
  for (const NamedLoop& pool : parallel_loops())
    for (const ExecutorKind executor : {ExecutorKind::kFused, ExecutorKind::kSweep}) {
      INFO(pool.name << ", " << to_string(executor));
      int loops = 0;
      const ParallelFor counting = [&](int count, const std::function<void(int)>& body) {
        ++loops;
        pool.loop(count, body);
      };
      CHECK(digest_of_work(base, counting, executor, 5) == expected);
      CHECK(loops > 2);  // subdivide, visit, digest
    }
}
