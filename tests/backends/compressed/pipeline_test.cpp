// What is a pipeline, and that a program's own codec and filter reach the blocks of a store.
#include "plait/extend/pipeline.h"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>

#include "backends/compressed/filters/predicted_levels.h"
#include "plait/compression.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/extend/pipeline_registry.h"
#include "plait/extend/recode_attribute.h"
#include "plait/extend/store_access.h"
#include "plait/registry.h"
#include "plait/store.h"
#include "store/attribute_levels.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

ErrorCode refusal_of(const char* pipeline, const char* words) {
  try {
    default_pipelines().open(pipeline, {});
  } catch (const Error& error) {
    CAPTURE(pipeline, error.what());
    CHECK(std::string(error.what()).find(words) != std::string::npos);
    return error.code();
  }
  FAIL("\"" << pipeline << "\" was taken");
  return {};
}

std::atomic<int> encoded_blocks = 0, decoded_blocks = 0;

/// Turns the bits of every byte round.
class ComplementFilter final : public Filter {
 public:
  void encode(const FilterBlock&, std::span<const std::byte> raw,
              std::span<std::byte> filtered) const override {
    ++encoded_blocks;
    std::ranges::transform(raw, filtered.begin(), [](std::byte b) { return ~b; });
  }
  void decode(const FilterBlock&, std::span<const std::byte> filtered,
              std::span<std::byte> raw) const override {
    ++decoded_blocks;
    std::ranges::transform(filtered, raw.begin(), [](std::byte b) { return ~b; });
  }
};

PipelineRegistry with_complement() {
  PipelineRegistry pipelines = default_pipelines();
  pipelines.add(RegisteredFilter{
      "x-flip", "turns the bits round",
      [](std::string_view, const FilterLevel&) { return std::make_unique<ComplementFilter>(); }});
  return pipelines;
}

}  // namespace

TEST_CASE("Pipeline_WellFormedText_HasItsFiltersInOrder") {
  const struct {
    const char* text;
    ComponentType type;
    std::size_t filters;
  } cases[] = {{"lz4", ComponentType::kFloat32, 0},
               {"none", ComponentType::kFloat32, 0},
               {"none,zstd:3", ComponentType::kFloat32, 0},
               {"shuffle,none", ComponentType::kFloat32, 1},
               {"shuffle,zstd", ComponentType::kUint8, 0},
               {"shuffle+none+shuffle,zstd:-5", ComponentType::kInt64, 2}};
  for (const auto& [text, type, filters] : cases) {
    CAPTURE(text);
    const OpenPipeline made = default_pipelines().open(text, {.schema = {.type = type}});
    CHECK(made.codec != nullptr);
    CHECK(made.filters.size() == filters);
  }
}

TEST_CASE("Pipeline_AnythingElse_IsRefusedInWordsThatNameIt") {
  CHECK(refusal_of(
            "brotli",
            "codec \"brotli\" of pipeline \"brotli\": expected one of bitpack, lz4, none, zstd") ==
        ErrorCode::kNotSupported);
  CHECK(refusal_of("shuffle", "codec \"shuffle\"") == ErrorCode::kNotSupported);
  CHECK(refusal_of("delta,lz4",
                   "filter \"delta\" of pipeline \"delta,lz4\": expected one of columns, "
                   "hierarchy, lattice, normals, shuffle") == ErrorCode::kNotSupported);
  CHECK(refusal_of("shuffle+,lz4", "expected [FILTER+FILTER,]CODEC such as shuffle,zstd:1") ==
        ErrorCode::kInvalidArgument);
  CHECK(refusal_of(",lz4", "expected [FILTER+FILTER,]CODEC such as shuffle,zstd:1") ==
        ErrorCode::kInvalidArgument);
  CHECK(refusal_of("shuffle,", "expected [FILTER+FILTER,]CODEC such as shuffle,zstd:1") ==
        ErrorCode::kInvalidArgument);
  CHECK(refusal_of("", "expected [FILTER+FILTER,]CODEC such as shuffle,zstd:1") ==
        ErrorCode::kInvalidArgument);
  CHECK(refusal_of("shuffle:4,lz4", "shuffle:4") == ErrorCode::kInvalidArgument);
  CHECK(refusal_of("lz4:9", "lz4:9") == ErrorCode::kInvalidArgument);
  CHECK(refusal_of("zstd:99", "zstd:99") == ErrorCode::kInvalidArgument);
  CHECK(refusal_of("zstd:3,lz4", "filter \"zstd\"") == ErrorCode::kNotSupported);
}

TEST_CASE("Pipeline_FilterThatNeedsOtherBlocksAfterAnother_IsRefused") {
  const PredictedLevels<float> levels(BaseMesh::build(octahedron()), 2, 4096);
  for (const std::string filter : {"hierarchy", "hierarchy:loop", "hierarchy:step=1e-3"})
    for (const std::string first : {"shuffle", "columns", "hierarchy", "predicted+shuffle"}) {
      const std::string pipeline = first + "+" + filter + ",zstd:1";
      CAPTURE(pipeline);
      const Error error =
          error_of([&] { default_pipelines().open(pipeline, levels.filter_level(2)); });
      CHECK(error.code() == ErrorCode::kNotSupported);
      CHECK_THAT(error.what(), Catch::Contains("expected filter hierarchy in the first place"));
    }
}

TEST_CASE("PipelineRegistry_EntriesThatCannotBe_AreRefused") {
  PipelineRegistry pipelines = default_pipelines();
  const auto make = [](std::string_view) { return default_pipelines().make_codec({"none"}); };
  for (const char* name : {"lz4", "", "a,b", "a+b", "a:b", "a b"}) {
    CAPTURE(name);
    CHECK_THROWS_AS(pipelines.add(RegisteredCodec{name, "", make}), Error);
  }
  CHECK_THROWS_AS(pipelines.add(RegisteredCodec{"x-none", "", nullptr}), Error);
  CHECK_THROWS_AS(pipelines.add(RegisteredFilter{
                      "none", "", [](std::string_view, const FilterLevel&) { return nullptr; }}),
                  Error);
  pipelines.add(RegisteredCodec{"x-none", "", make});
  CHECK(pipelines.codec_names() ==
        std::vector<std::string>{"bitpack", "lz4", "none", "x-none", "zstd"});
}

TEST_CASE("Store_OfAProgramsOwnFilter_IsReadByThoseWhoHaveIt") {
  const TemporaryDirectory place;
  const BackendRegistry backends = default_backends(with_complement());
  const StoreOptions options{.backend = "compressed", .pipeline = "x-flip+shuffle,zstd:1"};
  encoded_blocks = decoded_blocks = 0;
  Digest written;
  {
    Store store = Store::create(place.path() / "own.plait", BaseMesh::build(icosahedron()), options,
                                backends);
    store.add_attribute(AttributeSchema{"a", ComponentType::kFloat32, 3});
    store.add_level(0);
    store.add_level(0);
    LevelFile& level = StoreAccess::level_file(store, 0, 2);
    const std::vector<std::byte> bytes(level.geometry.block_bytes(0), std::byte{7});
    level.backend->write({0, 1}, bytes);
    store.commit();
    written = digest(store, {});
  }
  CHECK(encoded_blocks == 1);
  Store store = Store::open(place.path() / "own.plait", {}, backends);
  CHECK(digest(store, {}) == written);
  CHECK(decoded_blocks > 0);
  try {
    Store::open(place.path() / "own.plait", {}, default_backends());
    FAIL("the filter is not there");
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::kNotSupported);
    CHECK(std::string(error.what()).find("x-flip") != std::string::npos);
  }
}

TEST_CASE("PipelineOfRounded_AnyPipeline_CountsInSteps") {
  CHECK(pipeline_of_rounded("hierarchy+shuffle,zstd:1", 2e-6) ==
        "hierarchy:step=2e-06+shuffle,zstd:1");
  CHECK(pipeline_of_rounded("hierarchy:midpoint+shuffle,lz4", 0.5) ==
        "hierarchy:midpoint:step=0.5+shuffle,lz4");
  CHECK(pipeline_of_rounded("hierarchy:loop:step=3+shuffle,lz4", 0.5) ==
        "hierarchy:loop:step=0.5+shuffle,lz4");
  CHECK(pipeline_of_rounded("hierarchy:step=3+shuffle,lz4", 0.5) ==
        "hierarchy:step=0.5+shuffle,lz4");
  CHECK(pipeline_of_rounded("columns+shuffle,lz4", 1e20) == "lattice:1e20+columns+shuffle,lz4");
  CHECK(pipeline_of_rounded("columns,bitpack", 1) == "lattice:1+columns,bitpack");
  CHECK(pipeline_of_rounded("lattice:7+columns,lz4", 1e-3) == "lattice:0.001+columns,lz4");
  CHECK(pipeline_of_rounded("lattice:7+shuffle,lz4", 1e-3) == "lattice:0.001+shuffle,lz4");
  CHECK(pipeline_of_rounded("normals+shuffle,zstd:9", 1) == "hierarchy:step=1+shuffle,zstd:9");
  CHECK(pipeline_of_rounded("shuffle,zstd:9", 1) == "shuffle,zstd:9");
  CHECK(pipeline_of_rounded("none", 1) == "none");
  CHECK(pipeline_of_rounded("predicted+hierarchy+shuffle,zstd:1", 1) ==
        "hierarchy:step=1+shuffle,zstd:1");
  CHECK(pipeline_of_rounded("predicted,zstd:1", 1) == "zstd:1");
  CHECK(pipeline_of_rounded("none;@1-2=predicted+hierarchy,lz4;@4=columns,zstd:1", 2) ==
        "none;@1-2=hierarchy:step=2,lz4;@4=lattice:2+columns,zstd:1");
}

namespace {

std::string pipelines_of(const char* attribute, const std::vector<const char*>& texts) {
  Compression compression;
  for (const char* text : texts) compression.add(text);
  return compression.pipeline_of({attribute, ComponentType::kFloat32, 2}).to_text();
}

std::string refusal_of(const std::vector<const char*>& texts, int base_level, int finest_level) {
  try {
    Compression compression;
    for (const char* text : texts) compression.add(text);
    compression.check_levels(base_level, finest_level);
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::kInvalidArgument);
    return error.what();
  }
  return {};
}

}  // namespace

TEST_CASE("Compression_TextForAnAttributeThatIsNotThere_IsRefusedWithThoseThatAre") {
  Compression compression;
  compression.add("small");
  compression.add("uv@2-=lz4");
  CHECK_NOTHROW(compression.check_attributes({"position", "uv"}));
  CHECK_THROWS_WITH(compression.check_attributes({"position", "normal"}),
                    "choose compression of attribute 'uv': expected one of position, normal");
}

TEST_CASE("Compression_TextsForLevels_TheNarrowerAndTheNamedGoFirst") {
  const std::string usual =
      preset_pipeline("default", {"uv", ComponentType::kFloat32, 2}).to_text();
  CHECK(pipelines_of("uv", {}) == usual);
  CHECK(pipelines_of("uv", {"@1-3=lz4"}) == usual + ";@1-3=lz4");
  CHECK(pipelines_of("uv", {"none", "uv@4-=zstd:1"}) == "none;@4-=zstd:1");
  CHECK(pipelines_of("other", {"none", "uv@4-=zstd:1"}) == "none");
  // In any order: the smaller range goes before the larger.
  CHECK(pipelines_of("uv", {"@2-8=zstd:2", "@4-5=zstd:4", "none"}) ==
        "none;@2-3=zstd:2;@4-5=zstd:4;@6-8=zstd:2");
  CHECK(pipelines_of("uv", {"none", "@4-5=zstd:4", "@2-8=zstd:2"}) ==
        "none;@2-3=zstd:2;@4-5=zstd:4;@6-8=zstd:2");
  // The attribute's own text goes before those for all attributes, also if its range is larger.
  CHECK(pipelines_of("uv", {"@4-5=zstd:4", "uv=lz4"}) == "lz4");
  CHECK(pipelines_of("uv", {"uv@2-6=lz4", "@4-5=zstd:4", "@1-3=zstd:2", "none"}) ==
        "none;@1=zstd:2;@2-6=lz4");
  // The later of two texts about the same.
  CHECK(pipelines_of("uv", {"@2=zstd:4", "@2=zstd:5", "uv@3-=lz4", "uv@3-=none", "lz4"}) ==
        "lz4;@2=zstd:5;@3-=none");
  CHECK(pipelines_of("uv", {"fast", "@0-=none"}) == "none");
  // A preset is that of the attribute; options have equals signs of their own.
  CHECK(pipelines_of("uv", {"none", "@1=fast"}) == "none;@1=columns,bitpack");
  CHECK(pipelines_of("uv", {"hierarchy:step=3+shuffle,lz4", "@1=lattice:3,x-codec:a=1@2"}) ==
        "hierarchy:step=3+shuffle,lz4;@1=lattice:3,x-codec:a=1@2");
}

TEST_CASE("Compression_LevelsThatCannotBe_AreRefusedInWords") {
  CHECK(refusal_of({"@1-3=lz4", "@2-4=none"}, 0, 9) ==
        "choose compression of all attributes: expected ranges of levels that are apart or one "
        "inside the other, found 1-3 and 2-4");
  CHECK(refusal_of({"uv@1-3=lz4", "uv@3-=none"}, 0, 9).find("of uv: ") != std::string::npos);
  CHECK(refusal_of({"uv@1-3=lz4", "@3-=none", "position@2-4=lz4"}, 0, 9).empty());
  CHECK(refusal_of({"@1-3=lz4;@5=none"}, 0, 9).find("a text of its own") != std::string::npos);
  CHECK(refusal_of({"uv@1-3"}, 0, 9).find("no pipeline follows") != std::string::npos);
  for (const char* text : {"@=lz4", "@3-1=lz4", "uv@x=lz4", "@21=lz4", "@1=", "=lz4", "@1-3=a;b"}) {
    CAPTURE(text);
    CHECK_FALSE(refusal_of({text}, 0, 9).empty());
  }
  CHECK(refusal_of({"@7-9=lz4"}, 0, 5) ==
        "choose compression of levels 7-9: expected levels from 1 to 5");
  CHECK(refusal_of({"@6-=lz4"}, 0, 5).find("levels 6-: expected levels from 1 to 5") !=
        std::string::npos);
  CHECK(refusal_of({"@3-7=lz4"}, 0, 5) ==
        "choose compression of levels 3-7: expected levels from 1 to 5; 3- are all levels from 3");
  CHECK(refusal_of({"@1-2=lz4"}, 2, 5) ==
        "choose compression of levels 1-2: expected levels from 3 to 5, because the vertices of "
        "levels 0 to 2 are in the base mesh, which is not compressed");
  for (const char* text : {"@0-3=lz4", "@3=lz4", "@1-=lz4", "@5-=lz4", "uv=lz4", "@0-5=lz4"}) {
    CAPTURE(text);
    CHECK(refusal_of({text}, 2, 5).empty());
  }
}

TEST_CASE("Store_PipelinesOfLevels_AreThoseOfTheirRanges") {
  const TemporaryDirectory place;
  const StoreOptions options{.backend = "compressed",
                             .pipeline = "shuffle,zstd:1;@1-2=lz4;@4-=none"};
  const auto path = place.path() / "s.plait";
  {
    Store store = Store::create(path, BaseMesh::build(icosahedron()), options, default_backends());
    store.add_attribute(AttributeSchema{"a", ComponentType::kFloat32, 3}, 3);
    CHECK(pipelines_of_levels(store, 0) == "shuffle,zstd:1;@1-2=lz4");
    CHECK_THROWS_AS(store.set_pipeline(0, "lz4;@2=rar"), Error);
    CHECK_THROWS_AS(store.set_pipeline(0, "lz4;@2-1=none"), Error);
    store.commit();
  }
  // The store keeps what it has been told of levels to come.
  Store store = Store::open(path, {.writable = true}, default_backends());
  store.add_level(0);
  const char* const expected[] = {"lz4", "lz4", "shuffle,zstd:1", "none"};
  for (int level = 1; level <= 4; ++level)
    CHECK(StoreAccess::level_file(store, 0, level).pipeline == expected[level - 1]);
  CHECK(pipelines_of_levels(store, 0) == "none;@1-2=lz4;@3=shuffle,zstd:1");
  const AttributeId other = store.add_attribute(AttributeSchema{"b", ComponentType::kUint8, 1});
  CHECK(pipelines_of_levels(store, other) == options.pipeline);
}

TEST_CASE("Recode_WithVerify_DecodesTheNewLevelsBeforeTheOldOnesGo") {
  /// Decodes to other bytes than it encoded.
  class ForgetfulFilter final : public Filter {
   public:
    void encode(const FilterBlock&, std::span<const std::byte> raw,
                std::span<std::byte> filtered) const override {
      std::ranges::copy(raw, filtered.begin());
    }
    void decode(const FilterBlock&, std::span<const std::byte> filtered,
                std::span<std::byte> raw) const override {
      std::ranges::copy(filtered, raw.begin());
      raw.front() ^= std::byte{1};
    }
  };
  PipelineRegistry pipelines = default_pipelines();
  pipelines.add(RegisteredFilter{"x-forgets", "", [](std::string_view, const FilterLevel&) {
                                   return std::make_unique<ForgetfulFilter>();
                                 }});
  const TemporaryDirectory place;
  Store store =
      Store::create(place.path() / "s.plait", BaseMesh::build(icosahedron()),
                    {.backend = "compressed", .io_threads = 0}, default_backends(pipelines));
  store.add_attribute(AttributeSchema{"a", ComponentType::kFloat32, 3}, 2);
  for (const int level : {1, 2}) {
    LevelFile& file = StoreAccess::level_file(store, 0, level);
    file.backend->write({0, 1}, std::vector<std::byte>(file.geometry.block_bytes(0)));
  }
  store.commit();
  const Digest before = digest(store, {});
  RecodeOptions verified{.verify = true};
  std::uint64_t done = 0, total = 0;
  verified.progress = [&](const Progress& now) {
    done = now.done, total = now.total;
    return true;
  };
  recode_attribute(store, 0, "lz4;@2=zstd:1", verified);
  CHECK(pipelines_of_levels(store, 0) == "zstd:1;@1=lz4");
  CHECK(done == total);
  CHECK(total == 2 * bytes_of_levels(store, 0));
  try {
    recode_attribute(store, 0, "x-forgets,lz4", verified);
    FAIL("other bytes were taken");
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::kCorruption);
  }
  CHECK(store.attributes().size() == 1);
  CHECK(pipelines_of_levels(store, 0) == "zstd:1;@1=lz4");
  CHECK(digest(store, {}) == before);
  store.commit();
}

}  // namespace plait::test
