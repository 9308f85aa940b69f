#include "durability/workload.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "durability/faults.h"
#include "engine/store/sample_store.h"
#include "plait/extend/store_access.h"
#include "plait/registry.h"
#include "plait/verify.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

constexpr std::uint64_t kBudgetBytes = 64 << 10;

const AttributeSchema kPosition{"position", ComponentType::kFloat32, 3};
const AttributeSchema kNoise{"noise", ComponentType::kUint8, 5};

void commit(Store& store, CommitObserver& observer) {
  const std::uint64_t version = store.sequence() + 1;
  observer.committing(version);
  store.commit();
  observer.committed(version);
}

void append(Store& store, AttributeId attribute, int level) {
  store.add_level(attribute);
  write_level(store, attribute, level,
              sample_level(store, store.attributes()[attribute].schema, level));
}

/// The steps of the run; each ends with a commit. The store is open before and after each.
const std::vector<void (*)(Store&)>& first_steps() {
  static const std::vector<void (*)(Store&)> steps = {
      [](Store& store) { add_sample(store, kPosition, 1); },
      [](Store& store) {
        append(store, 0, 2);
        add_sample(store, kNoise, 1);
      },
      [](Store& store) {
        for (const int level : {1, 2}) change_blocks(store, 0, level, 1);
        append(store, 0, 3);
      },
  };
  return steps;
}

using Steps = std::vector<void (*)(Store&)>;

const Steps& second_steps() {
  static const Steps steps = [] {
    Steps made = {
        [](Store& store) {
          change_blocks(store, 0, 3, 2);
          store.base_bytes(0)[5] ^= std::byte{1};
          store.replace_attribute(1, add_sample(store, {"other", ComponentType::kUint8, 5}, 2));
        },
        // Another version with the same blocks.
        [](Store& store) { StoreAccess::set_provenance(store, store.provenance()); },
        // Of the eight blocks, few at a time, and then all: in the change log, until it is full.
        [](Store& store) { change_blocks(store, 0, 3, 5); },
        [](Store& store) { change_blocks(store, 0, 3, 100); },
        [](Store& store) { change_blocks(store, 0, 3, 3); },
        [](Store& store) { change_blocks(store, 0, 3, 1); },
        [](Store& store) {
          change_blocks(store, 0, 1, 1);
          StoreAccess::pager(store).flush();
          change_blocks(store, 0, 1, 1);
          change_blocks(store, 1, 2, 1);
        },
    };
    // One block and one base record so often that a new log begins, to which the block is copied.
    made.insert(made.end(), 9, [](Store& store) {
      change_blocks(store, 0, 3, 100);
      store.base_bytes(0)[7] ^= std::byte{1};
    });
    return made;
  }();
  return steps;
}

}  // namespace

void change_blocks(Store& store, AttributeId attribute, int level, std::uint64_t step) {
  LevelFile& file = StoreAccess::level_file(store, attribute, level);
  Session session = StoreAccess::open_session(store);
  for (std::uint64_t block = 0; block < file.geometry.block_count(); block += step) {
    const PinnedBlock pinned = session.pin(file, block, Access::kUpdate);
    for (std::byte& byte : pinned.bytes())
      byte = static_cast<std::byte>(std::to_integer<unsigned>(byte) + 1);
  }
}

Store create_store(const std::filesystem::path& path, const std::string& backend,
                   Durability durability) {
  StoreOptions options = sample_options(backend);
  options.budget_bytes = kBudgetBytes;
  options.durability = durability;
  return Store::create(path, BaseMesh::build(torus_grid(8, 6)), options, default_backends());
}

void run_workload(const std::filesystem::path& path, const std::string& backend,
                  CommitObserver& observer) {
  {
    Store store = create_store(path, backend);
    for (const auto step : first_steps()) {
      step(store);
      commit(store, observer);
    }
  }
  Store store =
      Store::open(path, {.writable = true, .budget_bytes = kBudgetBytes}, default_backends());
  for (const auto step : second_steps()) {
    step(store);
    commit(store, observer);
  }
  change_blocks(store, 0, 2, 1);
  append(store, 1, 3);
  StoreAccess::pager(store).flush();
}

std::vector<Digest> digests_of_undisturbed_run(const std::filesystem::path& path,
                                               const std::string& backend) {
  std::vector<Digest> versions(1);
  Store store = create_store(path, backend, Durability::kNone);
  for (const auto* steps : {&first_steps(), &second_steps()})
    for (const auto step : *steps) {
      step(store);
      store.commit();
      versions.push_back(digest(store));
    }
  return versions;
}

std::uint64_t version_found(const std::filesystem::path& path,
                            const std::vector<Digest>& versions) {
  const NoWaiting no_waiting;
  std::uint64_t version = 0;
  for (const bool writable : {false, true}) {
    try {
      Store store = Store::open(path, {.writable = writable, .budget_bytes = kBudgetBytes},
                                default_backends());
      if (writable) REQUIRE(store.sequence() == version);
      version = store.sequence();
      REQUIRE(version < versions.size());
      REQUIRE(verify(store).damaged_count == 0);
      REQUIRE(digest(store) == versions[version]);
    } catch (const Error& error) {
      INFO(error.what());
      REQUIRE((error.code() == ErrorCode::kNotFound || error.code() == ErrorCode::kCorruption));
      REQUIRE_FALSE(writable);
      return 0;
    }
  }
  return version;
}

}  // namespace plait::test
