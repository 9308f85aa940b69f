// Jobs by their names: what their options take, and what they refuse.
#include "plait/job.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "support/answering_operations.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"

namespace plait::test {
namespace {

using Json = nlohmann::json;

std::string octahedron_in(const TemporaryDirectory& here) {
  const std::filesystem::path path = here.path() / "m.off";
  std::ofstream(path) << "OFF\n6 8 0\n1 0 0\n-1 0 0\n0 1 0\n0 -1 0\n0 0 1\n0 0 -1\n"
                         "3 0 2 4\n3 2 1 4\n3 1 3 4\n3 3 0 4\n"
                         "3 2 0 5\n3 1 2 5\n3 3 1 5\n3 0 3 5\n";
  return path.string();
}

std::string words_of(std::string_view job, const JobOptions& options,
                     const JobContext& context = {}) {
  return error_of([&] { run_job(job, options, {}, context); }).what();
}

}  // namespace

TEST_CASE("RunJob_OptionsThatAJobDoesNotTake_AreRefusedByTheirNames") {
  CHECK_THAT(words_of("copy", {}), Catch::Contains("subdivide, plan"));
  CHECK_THAT(words_of("convert", {{"blok", "1"}}),
             Catch::Contains("\"blok\"") && Catch::Contains("max-error"));
  CHECK_THAT(words_of("convert", {{"input", "a"}}), Catch::Contains("option output"));
  CHECK_THAT(words_of("convert", {{"output", "-"}}, {.option_prefix = "--"}),
             Catch::Contains("--output: expected a name"));
  const struct {
    const char *job, *option, *text, *words;
  } cases[] = {{"convert", "block", "1 mile", "whole number of bytes"},
               {"convert", "threads", "-1", "0 to 1024"},
               {"convert", "verify", "yes", "true or false"},
               {"import", "levels", "some", "1 to"},
               {"subdivide", "precision", "float16", "float32, float64"},
               {"subdivide", "input", "", "a name"}};
  for (const auto& [job, option, text, words] : cases) {
    const std::string found = words_of(job, {{option, text}});
    CAPTURE(found);
    CHECK_THAT(found, Catch::StartsWith(std::string(job) + ": " + option + ": "));
    CHECK_THAT(found, Catch::Contains(words));
  }
  CHECK_THAT(words_of("convert", {{"block", "4KiB"}, {"block", "8KiB"}}), Catch::Contains("twice"));
}

TEST_CASE("RunJob_Refusals_NameTheOptionThatAvoidsThem") {
  const TemporaryDirectory here;
  const std::string mesh = octahedron_in(here), store = (here.path() / "s").string();
  JobOptions options{{"input", mesh}, {"output", store}, {"levels", "2"}, {"threads", "0"}};
  const Json report = Json::parse(run_job("subdivide", options));
  CHECK(report["vertices"] == 66);
  CHECK(report["threads"] >= 1);
  CHECK(report["store"] == store);
  try {
    run_job("subdivide", options, {}, {.option_prefix = "--"});
    FAIL("expected a refusal");
  } catch (const JobError& error) {
    CHECK(error.option() == "force");
    CHECK_THAT(error.what(), Catch::EndsWith("; --force replaces a store"));
  }
  options.insert(options.end(), {{"force", "true"}, {"backend", "pread"}, {"compress", "fast"}});
  CHECK_THAT(words_of("subdivide", options), Catch::EndsWith("backend compressed (backend)"));
  CHECK_THAT(
      words_of(
          "convert",
          {{"input", store}, {"output", store + "2"}, {"backend", "pread"}, {"compress", "fast"}}),
      Catch::EndsWith("backend compressed (backend)"));
}

TEST_CASE("RunJob_CompressionOfAnAttributeThatIsNotThere_IsRefusedOrSaid") {
  const TemporaryDirectory here;
  const std::string mesh = octahedron_in(here), store = (here.path() / "s").string(),
                    copy = (here.path() / "c").string();
  const JobOptions made{{"input", mesh}, {"output", store}, {"levels", "2"}};
  const auto with = [](JobOptions options, const char* compress) {
    options.emplace_back("compress", compress);
    return options;
  };
  const char* const refusal = "choose compression of attribute 'normal': expected one of position";
  CHECK_THAT(words_of("subdivide", with(made, "normal=lz4")), Catch::Contains(refusal));
  run_job("subdivide", made);
  const JobOptions copied{{"input", store}, {"output", copy}};
  CHECK_THAT(words_of("convert", with(copied, "normal=lz4")), Catch::Contains(refusal));
  // The pass makes the attribute.
  run_job("pass", with({{"store", store}, {"kind", "normals"}, {"out", copy}}, "normal=lz4"));
  // A file is read before its attributes are known.
  std::vector<std::string> warnings;
  run_job("remesh",
          {{"input", mesh},
           {"output", copy},
           {"force", "true"},
           {"faces", "8"},
           {"levels", "1"},
           {"compress", "turned=lz4"},
           {"compress", "colour=lz4"},
           {"compress", "uv=lz4"}},
          {.warn = [&](const std::string& line) { warnings.push_back(line); }});
  for (const char* name : {"turned", "colour", "uv"}) {
    CAPTURE(name);
    CHECK(std::ranges::count_if(warnings, [&](const std::string& line) {
            return line.find("compression of attribute '" + std::string(name)) != line.npos;
          }) == (std::string_view(name) == "turned" ? 0 : 1));
  }
}

TEST_CASE("RunJob_PassAndConvert_ComputeOnThePoolOfTheProgram") {
  const TemporaryDirectory here;
  const std::string mesh = octahedron_in(here), store = (here.path() / "s").string(),
                    copy = (here.path() / "c").string();
  run_job("subdivide", {{"input", mesh}, {"output", store}, {"levels", "3"}});
  int bodies = 0;
  JobContext context;
  context.parallel_for = [&](int count, const std::function<void(int)>& body) {
    for (int i = 0; i < count; ++i, ++bodies) body(i);
  };
  const auto used = [&](std::string_view job, const JobOptions& options) {
    bodies = 0;
    run_job(job, options, {}, context);
    return bodies;
  };
  CHECK(used("pass", {{"store", store}, {"kind", "smooth"}, {"threads", "2"}}) > 0);
  CHECK(used("pass", {{"store", store}, {"kind", "noise"}, {"out", copy}, {"threads", "2"}}) > 0);
  CHECK(used("convert", {{"input", store},
                         {"output", copy},
                         {"threads", "2"},
                         {"verify", "true"},
                         {"force", "true"}}) > 0);
}

TEST_CASE("RunJob_ThatChangesNothingYet_SaysSoBeforeTheFirstFile") {
  const TemporaryDirectory here;
  const std::string mesh = octahedron_in(here), store = (here.path() / "s").string();
  const JobWatch watch{.before_files = [] { throw Error(ErrorCode::kCancelled, "not yet"); }};
  using Option = std::pair<std::string, std::string>;
  for (const auto& [job, size] :
       {std::pair("subdivide", Option("levels", "1")), std::pair("remesh", Option("faces", "8"))}) {
    const JobOptions options{{"input", mesh}, {"output", store}, size};
    CHECK(error_of([&] { run_job(job, options, watch); }).code() == ErrorCode::kCancelled);
    CHECK_FALSE(std::filesystem::exists(store));
  }
}

// Nothing in this job tells progress. It takes longer than the 50 ms between two questions.
TEST_CASE("RunJob_WithoutAnyProgressOfItsOwn_IsCancelledAllTheSame") {
  const TemporaryDirectory here;
  const std::string mesh = (here.path() / "m.ply").string();
  run_job("generate", {{"kind", "torus"}, {"out", mesh}, {"vertices", "400000"}});
  JobWatch watch;
  watch.progress = [](const Progress&) { return false; };
  const Error error = error_of([&] { run_job("check", {{"mesh", mesh}}, watch); });
  CHECK(error.code() == ErrorCode::kCancelled);
  CHECK_THAT(error.what(), Catch::Contains("check: cancelled"));
}

TEST_CASE("RunJob_WhereTheFileSystemHasNoLocks_SaysSoWithTheNameOfTheOutput") {
  const TemporaryDirectory here;
  const auto in = [&](const char* name) { return (here.path() / name).string(); };
  const std::string mesh = octahedron_in(here);
  const AnsweringOperations no_locks(FileOperation::Kind::kLock, ENOLCK);
  const std::pair<std::string_view, JobOptions> runs[] = {
      {"subdivide", {{"input", mesh}, {"output", in("s.plait")}, {"levels", "3"}}},
      {"convert", {{"input", in("s.plait")}, {"output", in("c.plait")}}},
      {"pass", {{"store", in("s.plait")}, {"kind", "noise"}, {"out", in("p.plait")}}},
      {"export", {{"input", in("s.plait")}, {"output", in("e.ply")}}},
      {"import", {{"input", in("e.ply")}, {"output", in("i.plait")}}},
      {"remesh",
       {{"input", in("e.ply")},
        {"output", in("r.plait")},
        {"faces", "8"},
        {"levels", "2"},
        {"samples", "0"}}}};
  for (const auto& [job, options] : runs) {
    CAPTURE(job);
    std::vector<std::string> lines;
    JobWatch watch;
    watch.warn = [&](const std::string& line) {
      if (line.find("has no locks") != std::string::npos) lines.push_back(line);
    };
    run_job(job, options, watch);
    if (job == "export") continue;
    REQUIRE(lines.size() == 1);
    const auto output = std::ranges::find_if(
        options, [](const auto& option) { return option.first.starts_with("out"); });
    CHECK_THAT(lines[0], Catch::StartsWith(output->second + ":"));
  }
}

}  // namespace plait::test
