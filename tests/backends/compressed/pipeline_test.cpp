// What is a pipeline, and that a program's own codec and filter reach the blocks of a store.
#include "plait/backends/pipeline.h"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>

#include "plait/backends/compression.h"
#include "plait/backends/registry.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/store.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

ErrorCode refusal_of(const char* pipeline, const char* words) {
  try {
    default_pipelines().make(pipeline, {});
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
  pipelines.add(PipelineRegistry::FilterEntry{
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
    FilterLevel level;
    level.schema.type = type;
    const Pipeline made = default_pipelines().make(text, level);
    CHECK(made.codec != nullptr);
    CHECK(made.filters.size() == filters);
  }
}

TEST_CASE("Pipeline_AnythingElse_IsRefusedInWordsThatNameIt") {
  CHECK(refusal_of("brotli",
                   "codec \"brotli\" of pipeline \"brotli\": expected one of lz4, none, zstd") ==
        ErrorCode::kNotSupported);
  CHECK(refusal_of("shuffle", "codec \"shuffle\"") == ErrorCode::kNotSupported);
  CHECK(refusal_of("delta,lz4",
                   "filter \"delta\" of pipeline \"delta,lz4\": expected one of bytedelta, "
                   "hierarchy, lattice, lorenzo, normals, parallelogram, shuffle") ==
        ErrorCode::kNotSupported);
  CHECK(refusal_of("shuffle+,lz4", " \"\" of pipeline") == ErrorCode::kNotSupported);
  CHECK(refusal_of(",lz4", " \"\" of pipeline") == ErrorCode::kNotSupported);
  CHECK(refusal_of("shuffle,", " \"\" of pipeline") == ErrorCode::kNotSupported);
  CHECK(refusal_of("", " \"\" of pipeline") == ErrorCode::kNotSupported);
  CHECK(refusal_of("shuffle:4,lz4", "shuffle:4") == ErrorCode::kInvalidArgument);
  CHECK(refusal_of("lz4:9", "lz4:9") == ErrorCode::kInvalidArgument);
  CHECK(refusal_of("zstd:99", "zstd:99") == ErrorCode::kInvalidArgument);
  CHECK(refusal_of("zstd:3,lz4", "filter \"zstd\"") == ErrorCode::kNotSupported);
}

TEST_CASE("PipelineRegistry_EntriesThatCannotBe_AreRefused") {
  PipelineRegistry pipelines = default_pipelines();
  const auto make = [](std::string_view) { return default_pipelines().make_codec("none"); };
  for (const char* name : {"lz4", "", "a,b", "a+b", "a:b", "a b"}) {
    CAPTURE(name);
    CHECK_THROWS_AS(pipelines.add(PipelineRegistry::CodecEntry{name, "", make}), Error);
  }
  CHECK_THROWS_AS(pipelines.add(PipelineRegistry::CodecEntry{"x-none", "", nullptr}), Error);
  CHECK_THROWS_AS(pipelines.add(PipelineRegistry::FilterEntry{
                      "none", "", [](std::string_view, const FilterLevel&) { return nullptr; }}),
                  Error);
  pipelines.add(PipelineRegistry::CodecEntry{"x-none", "", make});
  CHECK(pipelines.codec_names() == std::vector<std::string>{"lz4", "none", "x-none", "zstd"});
}

TEST_CASE("Store_OfAProgramsOwnFilter_IsReadByThoseWhoHaveIt") {
  const TemporaryDirectory place;
  const BackendRegistry backends = default_backends(with_complement());
  StoreOptions options;
  options.backend = "compressed";
  options.pipeline = "x-flip+shuffle,zstd:1";
  encoded_blocks = decoded_blocks = 0;
  Digest written;
  {
    Store store = Store::create(place.path() / "own.plait", BaseMesh::build(icosahedron()), options,
                                backends);
    store.add_attribute(AttributeSchema{"a", ComponentType::kFloat32, 3});
    store.add_level(0);
    store.add_level(0);
    LevelFile& level = store.level_file(0, 2);
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
  CHECK(pipeline_of_rounded("hierarchy:step=3+shuffle,lz4", 0.5) ==
        "hierarchy:step=0.5+shuffle,lz4");
  CHECK(pipeline_of_rounded("parallelogram+shuffle,lz4", 1e20) ==
        "lattice:1e20+lorenzo+shuffle,lz4");
  CHECK(pipeline_of_rounded("lattice:7+lorenzo,lz4", 1e-3) == "lattice:0.001+lorenzo,lz4");
  CHECK(pipeline_of_rounded("normals+shuffle,zstd:9", 1) == "hierarchy:step=1+shuffle,zstd:9");
  CHECK(pipeline_of_rounded("shuffle,zstd:9", 1) == "shuffle,zstd:9");
  CHECK(pipeline_of_rounded("none", 1) == "none");
  CHECK(pipeline_of_rounded("predicted+hierarchy+shuffle,zstd:1", 1) ==
        "hierarchy:step=1+shuffle,zstd:1");
  CHECK(pipeline_of_rounded("predicted,zstd:1", 1) == "zstd:1");
}

}  // namespace plait::test
