// What the caller hands to repair(): attributes that a program makes by itself are repaired without
// any kernel, and a recomputation that breaks its promise is refused.
#include <catch2/catch.hpp>

#include "engine/store/sample_store.h"
#include "plait/backends/registry.h"
#include "plait/repair.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

void flip(const std::filesystem::path& file, std::uint64_t offset) {
  overwrite_byte(file, offset, file_bytes(file)[offset] ^ std::byte{0x10});
}

/// Two attributes with levels 1 to 3, of which a byte each is flipped at level 3.
class DamagedSample {
 public:
  explicit DamagedSample(const std::string& backend = "pread") {
    Store store = Store::create(path(), BaseMesh::build(random_sheet(5, 120)),
                                sample_options(backend), default_backends());
    for (const AttributeSchema& schema : {kMade, kOther}) add_sample(store, schema, 3);
    store.commit();
    // Compressed blocks lie in the order in which threads wrote them, which differs between files.
    std::vector<std::uint64_t> offsets;
    for (AttributeId id = 0; id < 2; ++id) {
      damaged_.push_back(store.level_file(id, 3).path);
      offsets.push_back(store.level_file(id, 3).table[1].offset + 5);
    }
    store.close();
    for (std::size_t id = 0; id < 2; ++id) flip(damaged_[id], offsets[id]);
  }
  std::filesystem::path path() const { return directory_.path() / "s.plait"; }
  const std::filesystem::path& level_file() const { return damaged_[0]; }
  bool holds_sample(AttributeId attribute) const {
    Store store = Store::open(path(), {false, 1 << 20}, default_backends());
    return test::holds_sample(store, attribute);
  }
  RepairReport repair(const PlanRecomputation& recompute, RepairOptions options = {}) const {
    return plait::repair(path(), options, default_backends(), recompute);
  }

  static inline const AttributeSchema kMade = sample_schemas()[0], kOther = sample_schemas()[1];

 private:
  TemporaryDirectory directory_;
  std::vector<std::filesystem::path> damaged_;
};

/// Says that it makes the first attribute of the sample, and makes `schema`.
PlanRecomputation that_makes(const AttributeSchema& schema, int levels = 3, int* calls = nullptr) {
  return [=](const StoreCheck& check) {
    CHECK(check.attributes.size() == 2);
    Recomputation result;
    result.refusal = [](std::string_view name) {
      return name == DamagedSample::kMade.name ? "" : "only the sample's first attribute is made";
    };
    result.level_bytes = 1 << 20;
    result.make = [=](Store& made, int threads, const auto& proceed) {
      CHECK(threads == 2);
      if (calls != nullptr) ++*calls;
      if (!proceed(0, 1)) throw Error(ErrorCode::kCancelled, "the sample: cancelled");
      add_sample(made, schema, levels);
    };
    return result;
  };
}

}  // namespace

TEST_CASE("RepairRecomputation_OfAProgramsOwn_RebuildsWhatItMakes") {
  for (const std::string& backend : durable_backends())
    for (const std::uint64_t budget_bytes : {std::uint64_t{256} << 20, std::uint64_t{1} << 20}) {
      CAPTURE(backend, budget_bytes);
      const DamagedSample sample(backend);
      int calls = 0;
      const RepairReport report = sample.repair(that_makes(DamagedSample::kMade, 3, &calls),
                                                {.budget_bytes = budget_bytes, .threads = 2});
      CHECK(report.rebuilt_count == 1);
      REQUIRE(report.lost_count == 1);
      CHECK(report.lost[0].attribute == DamagedSample::kOther.name);
      CHECK_THAT(report.lost[0].reason, Catch::Contains("only the sample's first attribute"));
      CHECK(calls == 1);
      CHECK(sample.holds_sample(0));
      // A second repair has nothing to make.
      sample.repair(that_makes(DamagedSample::kMade, 3, &calls), {.threads = 2});
      CHECK(calls == 1);
    }
}

TEST_CASE("RepairRecomputation_ThatMakesSomethingElse_IsRefused") {
  const DamagedSample sample;
  AttributeSchema other_type = DamagedSample::kMade;
  other_type.type = ComponentType::kFloat64;
  for (const auto& [recompute, says] :
       {std::pair(that_makes(DamagedSample::kOther), "made none of this name"),
        std::pair(that_makes(other_type), "another type or finest level"),
        std::pair(that_makes(DamagedSample::kMade, 2), "another type or finest level")}) {
    const Error error = error_of([&] { sample.repair(recompute, {.threads = 2}); });
    CHECK(error.code() == ErrorCode::kInvalidArgument);
    CHECK(names(error, {says, DamagedSample::kMade.name}));
  }
  CHECK(sample.repair(that_makes(DamagedSample::kMade), {.threads = 2}).rebuilt_count == 1);
}

TEST_CASE("RepairRecomputation_Empty_MakesNothing") {
  const DamagedSample sample;
  const RepairReport report = sample.repair({});
  CHECK(report.rebuilt_count == 0);
  REQUIRE(report.lost_count == 2);
  CHECK_THAT(report.lost[0].reason, Catch::Contains("nothing was given that makes attribute"));
}

TEST_CASE("RepairRecomputation_WhileTheBaseMeshIsDamaged_IsNotAsked") {
  const DamagedSample sample;
  flip(sample.path() / "base.mesh", 40);
  flip(sample.path() / "attribute0.base.1", 0);
  bool asked = false;
  const RepairReport report = sample.repair([&](const StoreCheck&) {
    asked = true;
    return Recomputation{};
  });
  CHECK_FALSE(asked);
  CHECK(report.rebuilt_files.empty());
  REQUIRE(report.lost_files.size() == 2);
  CHECK_THAT(report.lost_files[1].reason, Catch::Contains("base.mesh, from which attributes are "
                                                          "computed anew, is damaged"));
}

TEST_CASE("RepairRecomputation_Cancelled_LeavesTheStore") {
  const DamagedSample sample;
  const std::vector<std::byte> before = file_bytes(sample.level_file());
  const Error error = error_of([&] {
    sample.repair(
        that_makes(DamagedSample::kMade),
        {.threads = 2, .proceed = [](std::string_view phase, std::uint64_t, std::uint64_t) {
           return phase != "compute anew";
         }});
  });
  CHECK(error.code() == ErrorCode::kCancelled);
  CHECK(file_bytes(sample.level_file()) == before);
}
