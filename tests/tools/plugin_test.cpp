// The program loads plug-ins by --plugin and PLAIT_PLUGINS, and says in one line what a store
// lacks.
#include <catch2/catch.hpp>
#include <cstdlib>
#include <string>
#include <vector>

#include "plait/mesh_io.h"
#include "support/test_meshes.h"
#include "workplace.h"

namespace plait::test {
namespace {

/// PLAIT_PLUGINS while this object lives.
class PluginList {
 public:
  explicit PluginList(const std::string& files) { ::setenv("PLAIT_PLUGINS", files.c_str(), 1); }
  ~PluginList() { ::unsetenv("PLAIT_PLUGINS"); }
  PluginList(const PluginList&) = delete;
  PluginList& operator=(const PluginList&) = delete;
};

struct PluginWorkplace : Workplace {
  PluginWorkplace() { write_ply(path("mesh.ply"), octahedron()); }
  Outcome must_subdivide(const Words& more) const {
    return succeed(
        {"subdivide", "mesh.ply", "--levels", "6", "--scheme", "midpoint", "--digest", "--json"},
        more);
  }
};

}  // namespace

TEST_CASE("Plugin_CodecOfIt_StoresAndReadsTheSameDigest") {
  const PluginWorkplace here;
  const Outcome memory = here.must_subdivide({"--backend", "memory"});
  const auto expected = memory.json()["digest"];
  const Outcome made = here.must_subdivide({"s.plait", "--backend", "compressed", "--compress",
                                            "x-delta+shuffle,x-runs", "--plugin", PLAIT_OWN_CODEC});
  CHECK(made.json()["digest"] == expected);

  // Every command that opens the store needs the plug-in, and says so in one line.
  for (const Words& command : std::vector<Words>{{"info", "s.plait"},
                                                 {"verify", "s.plait"},
                                                 {"verify", "s.plait", "--fast"},
                                                 {"repair", "s.plait", "--dry-run"},
                                                 {"digest", "s.plait"},
                                                 {"export", "s.plait", "s.ply"},
                                                 {"render", "s.plait", "s.png"},
                                                 {"convert", "s.plait", "t.plait"}}) {
    CAPTURE(command);
    const Outcome refused = here.plait(command);
    CAPTURE(refused.errors);
    CHECK(refused.status == 2);
    CHECK(refused.error_lines() == 1);
    CHECK(refused.errors.find("filter \"x-delta\" of pipeline \"x-delta+shuffle,x-runs\": expected "
                              "one of columns, hierarchy, lattice, normals, shuffle; "
                              "plug-ins add others (--plugin FILE, "
                              "PLAIT_PLUGINS)") != std::string::npos);
    Words with_plugin = command;
    with_plugin.insert(with_plugin.end(), {"--plugin", PLAIT_OWN_CODEC});
    CHECK(here.plait(with_plugin).status == 0);
  }
  // What the store says of itself can be read without the plug-in.
  const Outcome info = here.plait({"info", "s.plait"});
  CHECK(info.output.find("closed     open ") != std::string::npos);
  CHECK(info.output.find("base       level 0: 6 vertices") != std::string::npos);
  CHECK(info.output.find("  levels 1-6  x-delta+shuffle,x-runs\n") != std::string::npos);
  const Outcome json = here.plait({"info", "s.plait", "--json"});
  CHECK(json.status == 2);
  CHECK(json.json()["scheme"] == "midpoint");
  CHECK(json.json()["attributes"][0]["pipelines"][0]["last_level"] == 6);
  const PluginList list("/nonexistent.so");
  CHECK(here.plait({"clean", "."}).status == 0);  // opens no store
}

TEST_CASE("Plugin_ListOfTheEnvironment_IsLoaded") {
  const PluginWorkplace here;
  const PluginList list(std::string(PLAIT_OWN_BACKEND) + ":" + PLAIT_OWN_CODEC);
  const Outcome mapped = here.must_subdivide({"--backend", "x-map", "--plugin", PLAIT_OWN_CODEC});
  CHECK(mapped.json()["digest"] == here.must_subdivide({"--backend", "memory"}).json()["digest"]);

  const nlohmann::json build = here.report({"info", "--build"});
  REQUIRE(build["plugins"].size() == 2);
  CHECK(build["plugins"][0]["file"] == PLAIT_OWN_BACKEND);
  CHECK(build["plugins"][0]["backends"] == nlohmann::json({"x-map"}));
  CHECK(build["plugins"][1]["codecs"] == nlohmann::json({"x-runs"}));
  CHECK(build["codecs"] == nlohmann::json({"bitpack", "lz4", "none", "x-runs", "zstd"}));
  CHECK(build["backends"].size() == 6);
  const std::string text = here.plait({"info", "--build"}).output;
  CHECK(text.find("plug-in    " PLAIT_OWN_CODEC "\n  codecs     x-runs\n  filters    x-delta\n") !=
        std::string::npos);
}

TEST_CASE("Plugin_ThatCannotBeLoaded_EndsTheCommandInOneLine") {
  const PluginWorkplace here;
  const Outcome missing = here.plait({"info", "--build", "--plugin", "missing.so"});
  CHECK(missing.status == 2);
  CHECK(missing.error_lines() == 1);
  CHECK(missing.errors.find("missing.so") != std::string::npos);
  const Outcome mesh = here.plait({"info", "--build", "--plugin", "mesh.ply", "--json"});
  CHECK(mesh.status == 2);
  CHECK(mesh.json()["error"]["code"] == "invalid_argument");
  CHECK(mesh.errors ==
        "plait: load plug-in mesh.ply: expected a shared library, found a file of "
        "another kind\n");
}

}  // namespace plait::test
