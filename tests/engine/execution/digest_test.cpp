// The digest: the documented sum, computed again the plainest way.
#include "plait/digest.h"

#include <xxhash.h>

#include <catch2/catch.hpp>
#include <cstring>
#include <utility>

#include "engine/store/sample_store.h"
#include "plait/extend/store_access.h"
#include "plait/layout.h"
#include "plait/registry.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

__extension__ using Sum = unsigned __int128;

Sum number_of(const Digest& digest) { return Sum{digest.high} << 64 | digest.low; }

Sum hashed(VertexId start, VertexId end, int level, const std::string& name,
           std::span<const std::byte> bytes) {
  std::vector<unsigned char> message;
  for (const std::uint32_t value :
       {std::min(start, end), std::max(start, end), static_cast<std::uint32_t>(level)})
    for (int shift = 0; shift < 32; shift += 8)
      message.push_back(static_cast<unsigned char>(value >> shift));
  message.insert(message.end(), name.begin(), name.end());
  message.push_back(0);
  for (const std::byte byte : bytes) message.push_back(static_cast<unsigned char>(byte));
  const XXH128_hash_t hash = XXH3_128bits(message.data(), message.size());
  return Sum{hash.high64} << 64 | hash.low64;
}

/// The formula of plait/digest.h over what is born at `level`.
Sum naive_digest(Store& store, int level) {
  Sum sum = 0;
  for (AttributeId id = 0; id < store.attributes().size(); ++id) {
    const AttributeInfo& info = store.attributes()[id];
    if (level == store.base_level()) {
      const std::size_t record = info.schema.record_bytes();
      for (VertexId v = 0; v < store.base().vertex_count(); ++v)
        sum += hashed(v, v, level, info.schema.name,
                      std::as_const(store).base_bytes(id).subspan(v * record, record));
    } else if (level <= info.finest_level) {
      const std::vector<std::byte> bytes = read_level(store, id, level);
      const LevelGeometry& geometry = StoreAccess::level_file(store, id, level).geometry;
      for (EdgeId edge = 0; edge < store.base().edge_count(); ++edge) {
        const Edge& ends = store.base().edges()[edge];
        sum +=
            hashed(ends.start, ends.end, level, info.schema.name,
                   std::span(bytes).subspan(geometry.slot(edge).offset, geometry.slot(edge).bytes));
      }
    }
  }
  return sum;
}

Store filled(const std::filesystem::path& path, const std::string& backend, const BaseMesh& base,
             int base_level = 0, std::uint64_t block_bytes = 4096) {
  StoreOptions options = sample_options(backend, block_bytes);
  Store store = Store::create(path, base, options, default_backends(), {.base_level = base_level});
  for (const AttributeSchema& schema : sample_schemas())
    add_sample(store, schema, schema.name == "wide" ? 1 : 3);
  return store;
}

Store in_memory(const BaseMesh& base, int base_level = 0, std::uint64_t block_bytes = 4096) {
  return filled({}, "memory", base, base_level, block_bytes);
}

}  // namespace

TEST_CASE("Digest_AnyStore_IsTheDocumentedSumAndThatOfItsLevels") {
  for (const IndexedMesh& mesh : {random_sphere(3, 60), random_sheet(5, 60), single_triangle()})
    for (const int base_level : {0, 2}) {
      Store store = in_memory(BaseMesh::build(mesh), base_level);
      Sum sum = 0;
      for (int level = base_level; level <= base_level + 3; ++level) {
        const Sum expected = naive_digest(store, level);
        CHECK(number_of(digest(store, {level, 1, {}})) == expected);
        sum += expected;
      }
      CHECK(number_of(digest(store)) == sum);
      CHECK(number_of(digest(store, {-1, 2, {}})) == sum);
    }
}

TEST_CASE("Digest_NoAttribute_IsZero") {
  Store store = Store::create({}, BaseMesh::build(tetrahedron()), sample_options("memory"),
                              default_backends());
  CHECK(digest(store).to_string() == std::string(32, '0'));
}

TEST_CASE("DigestToString_LeadingZeros_AreKept") {
  CHECK(Digest{0x1234, 0xabcdef}.to_string() == "00000000000012340000000000abcdef");
}

TEST_CASE("Digest_OtherBackendBlockSizeOrBudget_IsTheSame") {
  const BaseMesh base = BaseMesh::build(random_sheet(5, 200));
  Store reference = in_memory(base);
  const Digest expected = digest(reference);
  for (const std::string& backend : durable_backends())
    for (const std::uint64_t block_bytes : {4096u, 1u << 20}) {
      const TemporaryDirectory directory(Medium::kMemory);
      filled(directory.path() / "s", backend, base, 0, block_bytes).commit();
      for (const std::uint64_t budget : {1u << 20, 16u << 20})
        for (const int threads : {1, 2}) {
          Store store =
              Store::open(directory.path() / "s", {.writable = false, .budget_bytes = budget},
                          default_backends());
          CHECK(digest(store, {-1, threads, {}}) == expected);
        }
    }
}

TEST_CASE("Digest_WithMoreThreadsThanTheBudgetHolds_TakesFewerAndSaysHowMany") {
  const BaseMesh base = BaseMesh::build(random_sheet(5, 300));
  Store reference = in_memory(base);
  const Digest expected = digest(reference);
  const TemporaryDirectory directory(Medium::kMemory);
  filled(directory.path() / "s", "pread", base, 0, 4096).commit();
  for (const auto& [budget, is_enough] :
       {std::pair{96u << 10, false}, std::pair{64u << 20, true}}) {
    CAPTURE(budget);
    const Store store =
        Store::open(directory.path() / "s", {.budget_bytes = budget}, default_backends());
    std::vector<int> taken;
    const DigestOptions options{.threads = 500,
                                .begins = [&](int threads) { taken.push_back(threads); }};
    CHECK(digest(store, options) == expected);
    REQUIRE(taken.size() == 1);
    CHECK(taken[0] >= 1);
    CHECK((taken[0] == 500) == is_enough);
  }
}

TEST_CASE("Digest_OtherOrderOfFaces_IsTheSame") {
  for (const IndexedMesh& mesh : {random_sphere(3, 200), random_sheet(5, 200), two_components()}) {
    const BaseMesh given = BaseMesh::build(mesh);
    Store reference = in_memory(given);
    const Digest expected = digest(reference);
    for (const LayoutKind kind : {LayoutKind::kSpatial, LayoutKind::kHilbert, LayoutKind::kRcm}) {
      const BaseMesh laid_out = lay_out(given, kind).mesh;
      CHECK_FALSE(std::ranges::equal(laid_out.faces(), given.faces()));
      Store store = in_memory(laid_out);
      for (AttributeId id = 0; id < 6; ++id) REQUIRE(holds_sample(store, id));
      CHECK(digest(store) == expected);
      for (int level = 0; level <= 3; ++level)
        CHECK(digest(store, {level, 1, {}}) == digest(reference, {level, 1, {}}));
    }
  }
}

TEST_CASE("Digest_OtherContent_IsAnother") {
  const BaseMesh base = BaseMesh::build(icosahedron());
  Store reference = in_memory(base);
  const Digest expected = digest(reference);

  Store flipped = in_memory(base);
  {
    const PinnedBlock pinned = StoreAccess::open_session(flipped).pin(
        StoreAccess::level_file(flipped, 2, 3), 0, Access::kUpdate);
    pinned.bytes()[17] ^= std::byte{1};
  }
  CHECK(digest(flipped) != expected);
  CHECK(digest(flipped, {2, 1, {}}) == digest(reference, {2, 1, {}}));

  Store exchanged = in_memory(base);  // the slots of two edges
  {
    LevelFile& file = StoreAccess::level_file(exchanged, 0, 1);
    const PinnedBlock pinned = StoreAccess::open_session(exchanged).pin(file, 0, Access::kUpdate);
    const auto slot = pinned.bytes().begin();
    std::swap_ranges(slot, slot + 12, slot + 12);
  }
  CHECK(digest(exchanged) != expected);

  Store other_base = in_memory(base);
  other_base.base_bytes(5)[0] ^= std::byte{128};
  CHECK(digest(other_base) != expected);

  Store other_level = in_memory(base, 1);
  CHECK(digest(other_level) != expected);
}

TEST_CASE("Digest_OptionsOutOfRange_AreRefused") {
  Store store = in_memory(BaseMesh::build(tetrahedron()), 1);
  for (const int level : {-2, 0, 5, 100}) {
    const Error error = error_of([&] { digest(store, {level, 1, {}}); });
    CHECK(error.code() == ErrorCode::kInvalidArgument);
    CHECK(names(error, {"expected 1 to 4"}));
  }
  for (const int threads : {-1, 1025}) {
    const Error error = error_of([&] { digest(store, {-1, threads, {}}); });
    CHECK(error.code() == ErrorCode::kInvalidArgument);
    CHECK(names(error, {"threads"}));
  }
}

TEST_CASE("Digest_Progress_RisesToTheTotalAndCancels") {
  Store store = in_memory(BaseMesh::build(random_sphere(3, 60)));
  for (const int level : {-1, 2}) {
    std::uint64_t last = 0, total = 0;
    digest(store, {level, 1, [&](const Progress& now) {
                     CHECK(now.done > last);
                     last = now.done;
                     total = now.total;
                     return true;
                   }});
    CHECK(last == total);
    CHECK(total == store.base().edge_count() * (level == -1 ? 5 * 3 + 1 : 5));
  }
  int calls = 0;
  const Error error = error_of([&] {
    digest(store, {-1, 1, [&](const Progress&) { return ++calls < 3; }});
  });
  CHECK(error.code() == ErrorCode::kCancelled);
  CHECK(calls == 3);
}
