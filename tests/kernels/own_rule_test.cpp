// A rule of a program's own: one digest from every executor, precision, backend and thread count,
// and the positions that the rule's formulas give in an independent program.
#include "plait/own_rule.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "kernels/oracle.h"
#include "kernels/run_variant.h"
#include "kernels/tension_rule.h"
#include "plait/error.h"
#include "support/sanitized.h"

using namespace plait;
using namespace plait::test;

namespace {

/// As Loop's rule is written in kernels/schemes/loop.h.
struct CopyOfLoop : OwnTensionRule {
  template <class V>
  V odd(V a, V b, V c, V d) const {
    return 0.375 * (a + b) + 0.125 * (c + d);
  }
  template <class V>
  V even(V v, V ring) const {
    return 0.4 * v + 0.1 * ring;
  }
  double even_weight(int valence) const {
    const double centre = 0.375 + 0.25 * std::cos(2 * std::numbers::pi / valence);
    return 1.6 * ((0.625 - centre * centre) / valence);
  }
  template <class V>
  V limit(V v, V ring) const {
    return 0.5 * v + ring / 12;
  }
  template <class V>
  V limit_border(V v, V p, V q) const {
    return (4 * v + (p + q)) / 6;
  }
  double limit_weight(int valence) const {
    return 1 / (valence + 0.375 / (even_weight(valence) / 1.6));
  }
};

/// Even vertices stay.
struct CopyOfMidpoint {
  static constexpr bool kReadsEndsOnly = true;

  template <class V>
  V odd(V a, V b, V, V) const {
    return 0.5 * (a + b);
  }
  template <class V>
  V odd_border(V a, V b) const {
    return 0.5 * (a + b);
  }
};

/// Gives other bits when the opposite vertices change places.
struct LopsidedRule {
  template <class V>
  V odd(V a, V b, V c, V d) const {
    return 0.375 * (a + b) + 0.125 * c + 0.124 * d;
  }
  template <class V>
  V odd_border(V a, V b) const {
    return 0.5 * (a + b);
  }
};

/// Says that it reads the ends only, and reads more.
struct DeceitfulRule : OwnTensionRule {
  static constexpr bool kReadsEndsOnly = true;
};

constexpr std::array kRuleExecutors = {ExecutorKind::kFused, ExecutorKind::kSweep,
                                       ExecutorKind::kTransparent};

/// One step of OwnTensionRule without a line of the library: new vertices from the coarse rings,
/// even ones from the new rings.
naive::Mesh naive_step(const naive::Mesh& coarse, const OwnTensionRule& rule) {
  naive::Mesh fine = naive::subdivide_midpoint(coarse);
  const naive::Rings coarse_rings(coarse), fine_rings(fine);
  const auto old_count = static_cast<naive::Index>(coarse.points.size());
  const auto& p = coarse.points;
  for (naive::Index made = old_count; made < fine.points.size(); ++made) {
    std::vector<naive::Index> ends;
    for (const naive::Index neighbour : fine_rings.find(made).neighbours)
      if (neighbour < old_count) ends.push_back(neighbour);
    REQUIRE(ends.size() == 2);
    const naive::Ring ring = coarse_rings.find(ends[0]);
    const auto n = ring.neighbours.size();
    const auto at = static_cast<std::size_t>(std::ranges::find(ring.neighbours, ends[1]) -
                                             ring.neighbours.begin());
    const naive::Point sum = p[ends[0]] + p[ends[1]];
    fine.points[made] =
        !ring.closed && (at == 0 || at + 1 == n)
            ? 0.5 * sum
            : (0.5 - rule.w) * sum + rule.w * (p[ring.neighbours[(at + n - 1) % n]] +
                                               p[ring.neighbours[(at + 1) % n]]);
  }
  for (naive::Index vertex = 0; vertex < old_count; ++vertex) {
    const naive::Ring ring = fine_rings.find(vertex);
    if (!ring.closed) {
      fine.points[vertex] = 0.5 * p[vertex] + 0.25 * (fine.points[ring.neighbours.front()] +
                                                      fine.points[ring.neighbours.back()]);
      continue;
    }
    naive::Point sum;
    for (const naive::Index neighbour : ring.neighbours) sum += fine.points[neighbour];
    fine.points[vertex] =
        (1 - rule.s) * p[vertex] + rule.s / static_cast<double>(ring.neighbours.size()) * sum;
  }
  return fine;
}

ErrorCode refusal(const std::function<void()>& call, const std::string& says) {
  try {
    call();
  } catch (const Error& error) {
    CHECK_THAT(error.what(), Catch::Contains(says));
    return error.code();
  }
  FAIL("expected an error");
  return {};
}

}  // namespace

TEST_CASE("OwnRule_EveryExecutorBackendAndThreadCount_GivesOneDigest") {
  const OneRingScheme scheme = own_scheme("tension", OwnTensionRule{});
  for (const IndexedMesh& mesh : {random_sphere(71, unless_sanitized(300u, 60u)),
                                  random_sheet(72, unless_sanitized(300u, 60u))})
    for (const bool double_precision : {false, true}) {
      const BaseMesh base = BaseMesh::build(mesh);
      std::string expected;
      for (const std::string backend : {"memory", "pread"})
        for (const ExecutorKind executor : kRuleExecutors)
          for (const int threads : {1, 2}) {
            Variant variant;
            variant.backend = backend;
            variant.executor = executor;
            variant.threads = threads;
            variant.double_precision = double_precision;
            const std::string digest =
                run(base, {.scheme = scheme, .levels = 4, .normals = true}, variant).digest;
            if (expected.empty()) expected = digest;
            INFO(fmt::format("{} {} {} threads", backend, to_string(executor), threads));
            CHECK(digest == expected);
          }
    }
}

TEST_CASE("OwnRule_AllTestMeshes_AgreeWithANaiveProgram") {
  const OwnTensionRule rule;
  const OneRingScheme scheme = own_scheme("tension", rule);
  for (const NamedMesh& named : all_meshes()) {
    if (named.mesh.faces.size() == 2 && named.mesh.positions.size() == 3)
      continue;  // two edges between the same vertices: naive_step() cannot tell them apart
    naive::Mesh oracle = to_naive(named.mesh);
    for (int level = 1; level <= 3; ++level) oracle = naive_step(oracle, rule);
    for (const ExecutorKind executor : kRuleExecutors) {
      INFO(named.name << ", executor " << to_string(executor));
      const SubdivideOptions options{.scheme = scheme, .executor = executor, .levels = 3};
      Store in_double = refine_in_memory(named.mesh, options, true);
      CHECK(worst_distance<Vector3<double>>(in_double, "position", oracle, oracle.points) < 1e-13);
      Store in_float = refine_in_memory(named.mesh, options);
      CHECK(worst_distance<Vector3<float>>(in_float, "position", oracle, oracle.points) < 1e-5);
    }
  }
}

// The same formulas give the library's bits: in the program's registers and in the library's.
TEST_CASE("OwnRule_WithTheFormulasOfALibraryScheme_HasItsDigest") {
  const OneRingScheme loop = own_scheme("copy-of-loop", CopyOfLoop{}),
                      midpoint = own_scheme("copied-midpoint", CopyOfMidpoint{});
  for (const IndexedMesh& mesh : {random_sphere(73, 200), random_sheet(74, 200)})
    for (const bool double_precision : {false, true})
      for (const ExecutorKind executor : kRuleExecutors)
        for (const auto& [own, scheme] :
             {std::pair(&loop, Scheme::kLoop), std::pair(&midpoint, Scheme::kMidpoint)}) {
          INFO(own->name() << ", " << to_string(executor));
          Variant variant;
          variant.executor = executor;
          variant.double_precision = double_precision;
          SubdivideOptions what{
              .scheme = scheme, .levels = 3, .limit = traits_of(scheme).has_limits};
          const BaseMesh base = BaseMesh::build(mesh);
          const std::string expected = run(base, what, variant).digest;
          what.scheme = *own;
          CHECK(run(base, what, variant).digest == expected);
        }
}

TEST_CASE("OwnRule_ThatBreaksItsPromises_IsRefused") {
  CHECK(refusal([] { own_scheme("lopsided", LopsidedRule{}); }, "change places") ==
        ErrorCode::kInvalidArgument);
  CHECK(refusal([] { own_scheme("deceitful", DeceitfulRule{}); }, "change places") ==
        ErrorCode::kInvalidArgument);
  const std::string too_long(kMostSchemeNameBytes + 1, 'x');
  for (const auto& [name, says] : {std::pair(std::string(), "found 0 bytes"),
                                   std::pair(std::string("two words"), "found byte 0x20 at 3"),
                                   std::pair(std::string("loop/1"), "found byte 0x2f at 4"),
                                   std::pair(std::string("a\nb"), "'a?b': expected a name"),
                                   std::pair(std::string("\x1b[2J"), "found byte 0x1b at 0"),
                                   std::pair(std::string("a\0b", 3), "found byte 0x00 at 1"),
                                   std::pair(too_long, "found 256 bytes")})
    CHECK(refusal([&] { own_scheme(name, OwnTensionRule{}); }, says) ==
          ErrorCode::kInvalidArgument);
  for (const SchemeTraits& scheme : schemes())
    CHECK(refusal([&] { own_scheme(std::string(scheme.name), OwnTensionRule{}); },
                  "the library has a scheme of this name") == ErrorCode::kInvalidArgument);
  const OneRingScheme scheme = own_scheme("tension", OwnTensionRule{});
  CHECK(refusal([&] { refine_in_memory(tetrahedron(), {.scheme = scheme, .limit = true}); },
                "scheme tension has no limit positions") == ErrorCode::kNotSupported);
}

TEST_CASE("OwnRule_InAStore_IsNamedByItsProvenance") {
  const OneRingScheme scheme = own_scheme("tension", OwnTensionRule{});
  SubdivideOptions options{.scheme = scheme};
  Store store = refine_in_memory(tetrahedron(), options);
  CHECK(store.provenance().scheme == "tension");
  // Levels of two rules are the work of neither.
  options.scheme = {};
  options.levels = 2;
  subdivide(store, options);
  CHECK(store.provenance().scheme.empty());
}

TEST_CASE("OwnRule_OfTheLongestName_IsStoredReopenedAndResumed") {
  const std::string name(kMostSchemeNameBytes, 'n');
  const OneRingScheme scheme = own_scheme(name, OwnTensionRule{});
  SubdivideOptions options{.scheme = scheme, .levels = 3};
  Store expected = refine_in_memory(tetrahedron(), options);

  const TemporaryDirectory directory;
  const std::filesystem::path path = directory.path() / "s.plait";
  {
    Store store = Store::create(path, BaseMesh::build(tetrahedron()), {}, default_backends());
    add_base_positions(store);
    options.levels = 1;
    subdivide(store, options);
    store.commit();
  }
  {
    Store store = Store::open(path, {.writable = true}, default_backends());
    CHECK(store.provenance().scheme == name);
    options.levels = 3;
    subdivide(store, options);
    store.commit();
  }
  Store store = Store::open(path, {}, default_backends());
  CHECK(store.provenance().scheme == name);
  CHECK(digest(store) == digest(expected));
}
