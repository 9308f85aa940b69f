// Store::roll_back() brings back the last commit, byte for byte, whatever was done since.
#include <catch2/catch.hpp>
#include <filesystem>
#include <functional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "engine/store/sample_store.h"
#include "plait/digest.h"
#include "plait/extend/store_access.h"
#include "plait/extend/sweep.h"
#include "plait/reader.h"
#include "plait/registry.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"
#include "support/usable_backends.h"

using namespace plait;
using namespace plait::test;

namespace {

constexpr int kRolledBackLevels = 3;

Store create_to_roll_back(const std::string& backend, const std::filesystem::path& path) {
  StoreOptions options = sample_options(backend);
  options.budget_bytes = 1 << 20;
  return Store::create(default_backends().find(backend).traits.in_memory ? "" : path,
                       BaseMesh::build(random_sheet(5, 60)), options, default_backends());
}

/// What a store is: names, levels, pipelines, records.
std::string content_of(Store& store) {
  std::string text = store.provenance().scheme;
  for (AttributeId id = 0; id < store.attributes().size(); ++id) {
    const AttributeInfo& info = store.attributes()[id];
    text += " " + info.schema.name + ":" + std::to_string(info.finest_level);
  }
  return text + " " + digest(store).to_string();
}

void change_blocks(Store& store, AttributeId id, int level, std::byte value, bool cancelled) {
  SweepPass pass;
  pass.name = "change";
  pass.accesses = {{id, level, level, Access::kUpdate}};
  pass.kernel = [&](const SweepView& view, EdgeId edge, int) {
    if (edge % 3 == 0) view.slot(0, level, edge).bytes[0] ^= value;
  };
  SweepOptions options;
  options.progress = [&](const Progress& now) { return !cancelled || now.done * 2 < now.total; };
  try {
    sweep(store, pass, options);
  } catch (const Error&) {
    if (!cancelled) throw;
  }
}

using RandomChange = std::function<void(Store&)>;

std::vector<RandomChange> random_changes() {
  return {
      [](Store& s) { change_blocks(s, 0, 3, std::byte{0x5a}, false); },
      [](Store& s) { change_blocks(s, 0, 2, std::byte{0x11}, true); },
      [](Store& s) { s.base_bytes(0)[5] ^= std::byte{1}; },
      [](Store& s) { s.add_level(0); },
      [](Store& s) {
        s.add_attribute({"new", ComponentType::kUint16, 1}, 2);
      },
      [](Store& s) { s.remove_attribute(1); },
      [](Store& s) {
        if (s.attributes().size() > 1) s.replace_attribute(0, 1);
      },
      [](Store& s) {
        Provenance provenance = s.provenance();
        provenance.scheme = "other";
        StoreAccess::set_provenance(s, provenance);
      },
      [](Store& s) { s.set_pipeline(0, *s.options().pipeline); },
  };
}

}  // namespace

TEST_CASE("StoreRollBack_BeforeTheFirstCommit_LeavesNoAttribute") {
  for (const std::string& backend : usable_backends()) {
    CAPTURE(backend);
    const TemporaryDirectory directory(Medium::kMemory);
    Store store = create_to_roll_back(backend, directory.path() / "s.plait");
    for (int time = 0; time < 3; ++time) {
      const AttributeId id = add_sample(store, sample_schemas()[0], kRolledBackLevels);
      CHECK(holds_sample(store, id));
      change_blocks(store, id, 2, std::byte{1}, time == 1);
      store.roll_back();
      CHECK(store.attributes().empty());
      CHECK(store.sequence() == 0);
    }
    const AttributeId id = add_sample(store, sample_schemas()[0], kRolledBackLevels);
    CHECK(holds_sample(store, id));
    CHECK_NOTHROW(store.commit());
    CHECK(holds_sample(store, id));
  }
}

TEST_CASE("StoreRollBack_AfterRandomChanges_BringsBackTheLastCommit") {
  for (const std::string& backend : usable_backends())
    for (std::uint32_t seed = 0; seed < 12; ++seed) {
      CAPTURE(backend, seed);
      const TemporaryDirectory directory(Medium::kMemory);
      const std::filesystem::path path = directory.path() / "s.plait";
      Store store = create_to_roll_back(backend, path);
      add_sample(store, sample_schemas()[0], kRolledBackLevels);
      AttributeSchema other = sample_schemas()[0];
      other.name = "other";
      add_sample(store, other, kRolledBackLevels);
      if (seed % 2 == 1) {  // the version before the last one is overwritten in part
        store.commit();
        change_blocks(store, 0, 3, std::byte{0x77}, false);
      }
      store.commit();
      const std::string committed = content_of(store);
      const std::uint64_t sequence = store.sequence();
      std::mt19937 random(seed);
      const std::vector<RandomChange> all = random_changes();
      for (int round = 0; round < 3; ++round) {
        for (int step = 0; step < 4; ++step) try {
            all[random() % all.size()](store);
          } catch (const Error&) {  // what an earlier change has taken away
          }
        store.roll_back();
        CHECK(content_of(store) == committed);
        CHECK(store.sequence() == sequence);
      }
      change_blocks(store, 1, 1, std::byte{3}, false);
      const std::string changed = content_of(store);
      CHECK(changed != committed);
      CHECK_NOTHROW(store.commit());
      if (default_backends().find(backend).traits.in_memory) continue;
      store.close();
      Store again = Store::open(path, {}, default_backends());
      CHECK(content_of(again) == changed);
    }
}

TEST_CASE("StoreRollBack_WhileItIsForbidden_IsRefused") {
  const TemporaryDirectory directory(Medium::kMemory);
  Store store = create_to_roll_back("pread", directory.path() / "s.plait");
  add_sample(store, sample_schemas()[0], 1);
  store.commit();
  {
    const Reader reader(std::as_const(store));
    CHECK(error_of([&] { store.roll_back(); }).code() == ErrorCode::kBusy);
  }
  DigestOptions options;
  int refused = 0;
  options.progress = [&](const Progress&) {
    refused += error_of([&] { store.roll_back(); }).code() == ErrorCode::kBadState ? 1 : 0;
    return true;
  };
  digest(store, options);
  CHECK(refused > 0);
  store.close();
  CHECK(error_of([&] { store.roll_back(); }).code() == ErrorCode::kBadState);
  Store read = Store::open(directory.path() / "s.plait", {}, default_backends());
  CHECK(error_of([&] { read.roll_back(); }).code() == ErrorCode::kBadState);
}
