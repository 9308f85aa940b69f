// The text of the pipelines of an attribute: what it means, and what is no such text.
#include "plait/extend/pipeline.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "plait/error.h"

using namespace plait;

namespace {

bool is_refused(std::string_view text) {
  try {
    LevelPipelines{text};
  } catch (const Error& error) {
    return error.code() == ErrorCode::kInvalidArgument;
  }
  return false;
}

}  // namespace

TEST_CASE("LevelRange_Text_NamesBothEnds") {
  CHECK(LevelRange::parse("4") == LevelRange{4, 4});
  CHECK(LevelRange::parse("0-3") == LevelRange{0, 3});
  CHECK(LevelRange::parse("6-") == LevelRange{6, kMaxLevel});
  CHECK(LevelRange::parse("20-20") == LevelRange{20, 20});
  for (const char* text : {"4", "1-3", "6-", "0-"})
    CHECK(LevelRange::parse(text).to_text() == text);
  for (const char* text : {"", "-", "-3", "3-1", "21", "1-21", "1--3", "+1", "1 -3", "1-3-4", "a",
                           "1-b", "99999999999999999999", "1-3 "}) {
    CAPTURE(text);
    CHECK_THROWS_AS(LevelRange::parse(text), Error);
  }
}

TEST_CASE("Pipeline_Text_IsAValueAndTheSameTextAgain") {
  const Pipeline pipeline = "predicted:a/b+x-delta:stride=3+shuffle,zstd:c=1,d=2";
  CHECK(pipeline.recipe == "a/b");
  CHECK(pipeline.filters == std::vector<PipelineStage>{{"x-delta", "stride=3"}, {"shuffle"}});
  CHECK(pipeline.codec == PipelineStage{"zstd", "c=1,d=2"});
  for (const char* text :
       {"none", "lz4", "zstd:-5", "none,lz4", "shuffle+none+shuffle,zstd", "predicted,zstd:1",
        "predicted+hierarchy,bitpack", "predicted:base+normals,bitpack", "a:b:c,d:e:f", "lz4:@1=x"})
    CHECK(Pipeline(text).to_text() == text);
  CHECK(Pipeline().to_text() == "none");
  CHECK_FALSE(Pipeline("predicted").has_predicted_stage());  // a codec
}

TEST_CASE("Pipeline_Recipe_BelongsToTheStage") {
  CHECK(Pipeline("predicted,lz4").recipe == "");
  CHECK_FALSE(Pipeline("shuffle,lz4").has_predicted_stage());
  CHECK(Pipeline("predicted:a+shuffle,lz4").with_recipe("c/d") ==
        Pipeline("predicted:c/d+shuffle,lz4"));
  CHECK(Pipeline("predicted:a,lz4").with_recipe("") == Pipeline("predicted,lz4"));
  CHECK(Pipeline("shuffle,lz4").with_recipe("c") == Pipeline("shuffle,lz4"));
  CHECK(Pipeline("predicted:a+shuffle,lz4").without_predicted_stage() == Pipeline("shuffle,lz4"));
  CHECK(Pipeline("predicted,lz4").without_predicted_stage() == Pipeline("lz4"));
  CHECK(Pipeline("predicted,a:b,c").without_predicted_stage() == Pipeline("none,a:b,c"));
}

TEST_CASE("Pipeline_AnythingElse_IsRefused") {
  for (const char* text :
       {"", ",", ",lz4", "shuffle,", "shuffle+,lz4", "+shuffle,lz4", "lz4:", "shuffle:,lz4", ":3",
        "l z4", "shuffle+predicted,lz4", "predicted+predicted,lz4", "lz4\n"}) {
    CAPTURE(text);
    CHECK(is_refused(text));
    CHECK_THROWS_AS(Pipeline{text}, Error);
  }
  CHECK_THROWS_AS(Pipeline("lz4;@1=none"), Error);  // of one level
}

TEST_CASE("LevelPipelines_Text_GivesEachLevelItsPipeline") {
  const LevelPipelines one = LevelPipelines("shuffle,zstd:1");
  for (int level = 0; level <= kMaxLevel; ++level) CHECK(one.of(level) == "shuffle,zstd:1");
  const LevelPipelines many = LevelPipelines("lz4;@1-3=none,x-codec:a=b,c=d;@5=zstd:1;@7-=none");
  const std::string codec = "none,x-codec:a=b,c=d";
  const char* const expected[] = {"lz4", "", "", "", "lz4", "zstd:1", "lz4", "none"};
  for (int level = 0; level <= kMaxLevel; ++level) {
    CAPTURE(level);
    const bool is_own = level >= 1 && level <= 3;
    CHECK(many.of(level) == (is_own ? codec : expected[std::min(level, 7)]));
  }
}

TEST_CASE("LevelPipelines_WhatWasParsed_IsWrittenAgainInOneWay") {
  for (const char* text : {"lz4", "lz4;@1=none", "lz4;@1-3=none;@4-=zstd:1"})
    CHECK(LevelPipelines(text).to_text() == text);
  // Neighbours with one pipeline become one range; what all levels have needs none.
  CHECK(LevelPipelines("lz4;@1=none;@2-3=none;@5=lz4").to_text() == "lz4;@1-3=none");
  LevelPipelines set("lz4");
  set.set({2, 8}, "none");
  set.set({4, 5}, "zstd:1");
  set.set({8, 8}, "lz4");
  CHECK(set.to_text() == "lz4;@2-3=none;@4-5=zstd:1;@6-7=none");
  set.for_each([](Pipeline& pipeline) { pipeline.filters.push_back({"a"}); });
  CHECK(set.to_text() == "a,lz4;@2-3=a,none;@4-5=a,zstd:1;@6-7=a,none");
  set.for_each([](Pipeline& pipeline) { pipeline = "b"; });
  CHECK(set == LevelPipelines("b"));
}

TEST_CASE("LevelPipelines_AnythingElse_IsRefused") {
  for (const char* text : {"lz4;", "lz4;;", "lz4;none", "lz4;1=none", "lz4;@1", "lz4;@=none",
                           "lz4;@1=", "lz4;@x=none", "lz4;@2=none;@1=none", "", ";@3-=lz4",
                           "lz4;@1-3=none;@3=zstd", "lz4;@1-21=none", "lz4;@1=none;"}) {
    CAPTURE(text);
    CHECK(is_refused(text));
  }
  // A long text ends at its first fault: ranges ascend, so there are at most 21 good ones.
  std::string hostile = "lz4";
  for (int i = 0; i < 10000; ++i) hostile += ";@0=x";
  CHECK(is_refused(hostile));
}
