// copy_levels(): the same content from any backend to any other.
#include "plait/extend/copy_levels.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "engine/store/sample_store.h"
#include "maintenance/compare_attribute.h"
#include "plait/digest.h"
#include "plait/extend/store_access.h"
#include "plait/registry.h"
#include "plait/store_info.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"
#include "support/usable_backends.h"

using namespace plait;
using namespace plait::test;

namespace {

bool is_durable(const std::string& backend) {
  return default_backends().find(backend).traits.durable;
}

Store create(const TemporaryDirectory& directory, const std::string& name, const BaseMesh& base,
             const StoreOptions& options, int base_level = 0) {
  return Store::create(
      is_durable(options.backend) ? directory.path() / name : std::filesystem::path(), base,
      options, default_backends(), {.base_level = base_level});
}

/// Attributes of several types and depths; in the last one nothing was written.
Store filled(const TemporaryDirectory& directory, const std::string& backend, int base_level = 0) {
  StoreOptions options = sample_options(backend);
  Store store =
      create(directory, "from", BaseMesh::build(random_sheet(5, 120)), options, base_level);
  for (const AttributeSchema& schema : sample_schemas())
    add_sample(store, schema, schema.name == "wide" ? 1 : 3);
  store.add_level(store.add_attribute({"empty", ComponentType::kInt64, 2}));
  store.commit();
  return store;
}

}  // namespace

TEST_CASE("CopyLevels_AnyBackendToAnyOther_KeepsEveryByte") {
  for (const std::string& from_backend : usable_backends())
    for (const std::string& to_backend : usable_backends())
      for (const std::uint64_t block_bytes : {4096u, 65536u}) {
        INFO(from_backend << " to " << to_backend << ", blocks of " << block_bytes);
        const TemporaryDirectory directory;
        Store from = filled(directory, from_backend);
        const Digest expected = digest(from);
        {
          Store to = create(directory, "to", from.base(), sample_options(to_backend, block_bytes));
          copy_levels(from, to);
          to.commit();
          CHECK(to.attributes().size() == 7);
          CHECK(digest(to) == expected);
          for (AttributeId id = 0; id < 6; ++id) CHECK(holds_sample(to, id));
          CHECK(to.info().paging.peak_frame_bytes <= 1 << 20);
        }
        if (!is_durable(to_backend)) continue;
        Store to = Store::open(directory.path() / "to",
                               {.writable = false, .budget_bytes = 1 << 20}, default_backends());
        CHECK(to.options().block_bytes == block_bytes);
        CHECK(digest(to) == expected);
        for (AttributeId id = 0; id < 7; ++id) {
          CHECK(to.attributes()[id].schema == from.attributes()[id].schema);
          CHECK(to.attributes()[id].finest_level == from.attributes()[id].finest_level);
        }
      }
}

TEST_CASE("CopyLevels_BetweenBlockSizes_ReadsAndWritesEveryBlockOnce") {
  for (const std::uint64_t from_bytes : {4096u, 65536u})
    for (const std::uint64_t to_bytes : {4096u, 65536u}) {
      const TemporaryDirectory directory;
      {
        Store store = create(directory, "from", BaseMesh::build(random_sheet(5, 300)),
                             sample_options("pread", from_bytes));
        add_sample(store, sample_schemas()[0], 4);
        store.commit();
      }
      Store from = Store::open(directory.path() / "from",
                               {.writable = false, .budget_bytes = 64 << 10}, default_backends());
      StoreOptions options = sample_options("pread", to_bytes);
      options.budget_bytes = 64 << 10;
      Store to = create(directory, "to", from.base(), options);
      copy_levels(from, to);
      to.commit();
      std::uint64_t bytes = 0, from_blocks = 0, to_blocks = 0;
      for (int level = 1; level <= 4; ++level) {
        bytes += StoreAccess::level_file(from, 0, level).geometry.total_bytes();
        from_blocks += StoreAccess::level_file(from, 0, level).geometry.block_count();
        to_blocks += StoreAccess::level_file(to, 0, level).geometry.block_count();
      }
      REQUIRE(bytes > 4 * (64 << 10));  // far more than the budgets
      CHECK(from.info().paging.blocks_read == from_blocks);
      CHECK(from.info().paging.bytes_read == bytes);
      CHECK(from.info().paging.blocks_written == 0);
      CHECK(to.info().paging.blocks_read == 0);
      CHECK(to.info().paging.blocks_written == to_blocks);
      CHECK(to.info().paging.bytes_written == bytes);
    }
}

TEST_CASE("CopyLevels_BaseLevelAboveZero_KeepsLevelNumbers") {
  const TemporaryDirectory directory;
  Store from = filled(directory, "pread", 3);
  StoreOptions options = sample_options("compressed");
  Store to = create(directory, "to", from.base(), options, 3);
  copy_levels(from, to);
  CHECK(to.finest_level() == 6);
  CHECK(digest(to) == digest(from));
}

TEST_CASE("CopyLevels_Progress_RisesToTheTotal") {
  for (const std::uint64_t block_bytes : {4096u, 1u << 20}) {
    const TemporaryDirectory directory;
    // At level 5 every slot of the first size is a block of its own.
    Store from = create(directory, "from", BaseMesh::build(tetrahedron()),
                        sample_options("memory", block_bytes));
    add_sample(from, sample_schemas()[0], 5);
    Store to = create(directory, "to", from.base(), sample_options("memory"));
    std::uint64_t last = 0, total = 0;
    copy_levels(from, to, [&](const Progress& now) {
      CHECK(now.done > last);
      last = now.done;
      total = now.total;
      return true;
    });
    CHECK(last == total);
    CHECK(total == 12u * 6 * (1 + 4 + 16 + 64 + 256));
  }
}

TEST_CASE("CopyLevels_Cancelled_Throws") {
  const TemporaryDirectory directory;
  Store from = filled(directory, "memory");
  Store to = create(directory, "to", from.base(), sample_options("pread"));
  int calls = 0;
  const Error error =
      error_of([&] { copy_levels(from, to, [&](const Progress&) { return ++calls < 4; }); });
  CHECK(error.code() == ErrorCode::kCancelled);
  CHECK(calls == 4);
}

TEST_CASE("CompareAttribute_RecordsBeyondTheBound_AreNamed") {
  for (const char* metric : {"component", "euclidean"}) {
    const TemporaryDirectory directory;
    const BaseMesh base = BaseMesh::build(random_sheet(5, 60));
    Store from = create(directory, "from", base, sample_options("memory"));
    from.add_attribute({"a", ComponentType::kFloat32, 2}, 2);
    for (const int level : {1, 2}) {
      std::vector<std::byte> bytes(StoreAccess::level_file(from, 0, level).geometry.total_bytes());
      for (std::size_t at = 0; at < bytes.size() / sizeof(float); ++at) {
        const float number = static_cast<float>(std::sin(static_cast<double>(at)));
        std::memcpy(bytes.data() + at * sizeof number, &number, sizeof number);
      }
      write_level(from, 0, level, bytes);
    }
    ErrorBounds bounds;
    bounds.add(std::string("a=1e-3,") + metric);
    Store to = create(directory, "to", base, sample_options("memory"));
    copy_levels(from, to, {}, bounds);
    const auto refusal = [&](const char* bound) -> std::string {
      std::optional<ErrorBound> most;
      if (bound != nullptr) most = ErrorBound::parse(std::string(bound) + "," + metric);
      try {
        compare_attribute(from, 0, to, 0, most);
      } catch (const Error& error) {
        CHECK(error.code() == ErrorCode::kCorruption);
        return error.what();
      }
      return {};
    };
    CHECK(refusal("1e-3").empty());
    CHECK(refusal("9e-4").find("within the bound of") != std::string::npos);
    CHECK(refusal(nullptr).find("equal to") != std::string::npos);

    // One record, moved by a little more than the bound.
    const std::vector<std::byte> exact = read_level(from, 0, 2);
    std::vector<std::byte> moved = read_level(to, 0, 2);
    float number;
    std::memcpy(&number, exact.data(), sizeof number);
    number += 1.001e-3f;
    std::memcpy(moved.data(), &number, sizeof number);
    write_level(to, 0, 2, moved);
    CHECK(refusal("1e-3").find("slot of edge 0 of level 2") != std::string::npos);
    int calls = 0;
    CHECK(error_of([&] {
            compare_attribute(from, 0, to, 0, {}, [&](const Progress&) { return ++calls < 1; });
          }).code() == ErrorCode::kCorruption);
    CHECK(error_of([&] {
            compare_attribute(from, 0, from, 0, {}, [&](const Progress&) { return ++calls < 1; });
          }).code() == ErrorCode::kCancelled);
    // Base records are never rounded.
    to.base_bytes(0).front() ^= std::byte{1};
    CHECK(refusal("1e-3").find("level 0") != std::string::npos);
  }
}
