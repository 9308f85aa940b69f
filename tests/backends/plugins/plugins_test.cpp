// Plug-ins are loaded or refused in words, and nothing of a refused one stays. The plug-ins of
// examples/ give the digests of the built-in backends.
#include "plait/extend/plugins.h"

#include <sys/stat.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "plait.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/extend/store_access.h"
#include "plait/registry.h"
#include "plait/subdivide.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

namespace fs = std::filesystem;
using Names = std::vector<std::string>;
using Bytes = std::vector<std::byte>;

/// "code: message" of the Error that `call` throws, or "".
template <class Call>
std::string error_text(Call&& call) {
  try {
    call();
  } catch (const Error& error) {
    CHECK(std::string_view(error.what()).find('\n') == std::string_view::npos);
    return std::string(to_string(error.code())) + ": " + error.what();
  }
  return "";
}

/// How the plug-in of the tests behaves while this object lives.
class Behaviour {
 public:
  explicit Behaviour(const char* what) { ::setenv("PLAIT_TEST_PLUGIN", what, 1); }
  ~Behaviour() { ::unsetenv("PLAIT_TEST_PLUGIN"); }
  Behaviour(const Behaviour&) = delete;
  Behaviour& operator=(const Behaviour&) = delete;
};

/// Middles of edges have coordinates of few bits, so a simple codec shortens them.
std::string digest_with(const fs::path& path, const StoreOptions& options,
                        const BackendRegistry& backends) {
  Store store = Store::create(path, BaseMesh::build(octahedron()), options, backends);
  add_base_positions(store);
  subdivide(store, {.scheme = Scheme::kMidpoint, .levels = 6, .normals = true});
  if (!path.empty()) store.commit();
  return digest(store).to_string();
}

std::string expected_digest() { return digest_with({}, {.backend = "memory"}, default_backends()); }

Bytes bytes_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

void write_bytes(const fs::path& path, std::span<const std::byte> bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

}  // namespace

TEST_CASE("Plugins_New_HasWhatIsBuiltIn") {
  const Plugins plugins;
  CHECK(plugins.loaded().empty());
  CHECK(plugins.backends().names() == default_backends().names());
  CHECK(plugins.pipelines().codec_names() == default_pipelines().codec_names());
}

TEST_CASE("PluginsLoad_CodecInC_IsThereBesideTheBuiltInOnes") {
  Plugins plugins;
  const BackendRegistry& backends = plugins.backends();
  const LoadedPlugin& loaded = plugins.load(PLAIT_OWN_CODEC);
  CHECK(loaded.file == PLAIT_OWN_CODEC);
  CHECK(loaded.backends.empty());
  CHECK(loaded.codecs == Names{"x-runs"});
  CHECK(loaded.filters == Names{"x-delta"});
  CHECK(plugins.pipelines().codec_names() == Names{"bitpack", "lz4", "none", "x-runs", "zstd"});
  CHECK(plugins.pipelines().filter_names() ==
        Names{"columns", "hierarchy", "lattice", "normals", "shuffle", "x-delta"});
  CHECK_NOTHROW(backends.find("compressed").check_pipelines("x-delta+shuffle,x-runs", {}));
  CHECK(default_pipelines().codec_names() == Names{"bitpack", "lz4", "none", "zstd"});

  // Again, and by a list: it is the same.
  CHECK(&plugins.load(PLAIT_OWN_CODEC) == &loaded);
  plugins.load_list("::" PLAIT_OWN_CODEC ":" PLAIT_OWN_BACKEND ":");
  CHECK(plugins.loaded().size() == 2);
  CHECK(&plugins.loaded().front() == &loaded);
  CHECK(plugins.loaded().back().backends == Names{"x-map"});
  CHECK(backends.find("x-map").summary == "keys and values in memory");
  CHECK_NOTHROW(backends.find("compressed").check_pipelines("x-runs", {}));
}

TEST_CASE("OwnCodec_StoreOfIt_HasTheSameDigestAndNeedsThePlugin") {
  const TemporaryDirectory here;
  const fs::path path = here.path() / "s.plait";
  Plugins plugins;
  plugins.load(PLAIT_OWN_CODEC);
  const StoreOptions options{.backend = "compressed", .pipeline = "x-delta+shuffle,x-runs"};
  CHECK(digest_with(path, options, plugins.backends()) == expected_digest());

  Store store = Store::open(path, {}, plugins.backends());
  CHECK(digest(store).to_string() == expected_digest());
  const auto position = store.attribute("position");
  std::uint64_t encoded = 0;
  for (const BlockEntry& entry : StoreAccess::level_file(store, position, 6).table.entries())
    encoded += entry.encoding == BlockEncoding::kEncoded ? 1 : 0;
  CHECK(encoded > 0);  // the codec has shortened something

  const std::string refused = error_text([&] { Store::open(path, {}, default_backends()); });
  CHECK(refused.starts_with("not_supported: open " + path.string()));
  CHECK(refused.find("filter \"x-delta\" of pipeline \"x-delta+shuffle,x-runs\": expected one of "
                     "columns, hierarchy, lattice, normals, shuffle; "
                     "plug-ins add others "
                     "(--plugin FILE, PLAIT_PLUGINS)") != std::string::npos);
}

TEST_CASE("PluginLoad_InC_MakesAndOpensStoresWithTheCodec") {
  const TemporaryDirectory here;
  const std::string path = (here.path() / "s.plait").string();
  const double corners[] = {1, 1, 1, 1, -1, -1, -1, 1, -1, -1, -1, 1};
  const std::uint32_t triangles[] = {0, 1, 2, 0, 3, 1, 0, 2, 3, 1, 3, 2};
  plait_store_options options PLAIT_STORE_OPTIONS_INIT;
  options.backend = "compressed";
  options.pipeline = "x-runs";
  plait_store* store = nullptr;
  const auto create = [&] {
    return plait_store_create(path.c_str(), corners, 4, triangles, 4, &options, &store);
  };
  CHECK(create() == PLAIT_ERROR_NOT_SUPPORTED);
  CHECK(plait_plugin_load(PLAIT_OWN_CODEC) == PLAIT_OK);
  CHECK(plait_plugin_load(PLAIT_OWN_CODEC) == PLAIT_OK);
  REQUIRE(create() == PLAIT_OK);
  CHECK(plait_store_commit(store) == PLAIT_OK);
  CHECK(plait_store_close(store) == PLAIT_OK);
  REQUIRE(plait_store_open(path.c_str(), nullptr, &store) == PLAIT_OK);
  plait_store_release(store);
}

TEST_CASE("OwnBackend_Subdivision_HasTheSameDigest") {
  Plugins plugins;
  plugins.load(PLAIT_OWN_BACKEND);
  StoreOptions options;
  options.backend = "x-map";
  options.budget_bytes = 1 << 20;  // so that blocks leave memory and come back
  options.block_bytes = 4096;
  CHECK(digest_with({}, options, plugins.backends()) == expected_digest());
}

TEST_CASE("OwnCodec_AnyBytes_AreDecodedOrRefused") {
  Plugins plugins;
  plugins.load(PLAIT_OWN_CODEC);
  const OpenPipeline made = plugins.pipelines().open("x-delta,x-runs", {});
  std::mt19937 random(1);
  for (int round = 0; round < 2000; ++round) {
    Bytes raw(random() % 400);
    const unsigned kinds = 1 + random() % 4;  // few kinds of bytes make runs
    std::ranges::generate(raw, [&] { return static_cast<std::byte>(random() % kinds); });
    Bytes stored(made.codec->bound(raw.size()));
    const auto bytes = made.codec->compress(raw, stored);
    if (raw.empty()) continue;
    REQUIRE(bytes.has_value());
    REQUIRE_FALSE(made.codec->compress(raw, std::span(stored).first(*bytes - 1)).has_value());
    made.codec->compress(raw, stored);
    stored.resize(*bytes);
    Bytes back(raw.size());
    made.codec->decompress(stored, back);
    REQUIRE(back == raw);

    Bytes filtered(raw.size());
    made.filters[0]->encode({}, raw, filtered);
    made.filters[0]->decode({}, filtered, back);
    REQUIRE(back == raw);

    // Damaged: memory of exactly these sizes, for the address sanitizer.
    stored[random() % stored.size()] ^= static_cast<std::byte>(1 + random() % 255);
    stored.resize(1 + random() % stored.size());
    stored.shrink_to_fit();
    const std::string text = error_text([&] { made.codec->decompress(stored, back); });
    REQUIRE((text.empty() || text.starts_with("corruption: decode x-runs: ")));
  }
}

TEST_CASE("PluginsLoad_PluginThatCannotBe_IsRefusedInWordsAndLeavesNothing") {
  struct Case {
    const char *what, *words;
  };
  const Case cases[] = {
      {"returns 3", "not_supported: load plug-in FILE: plait_plugin_v1 returned 3"},
      {"refuses", "not_supported: load plug-in FILE: no licence for this machine"},
      {"throws", "not_supported: load plug-in FILE: plait_plugin_v1 threw: a mistake"},
      {"throws 7", "not_supported: load plug-in FILE: plait_plugin_v1 threw an exception"},
      {"name twice",
       "invalid_argument: load plug-in FILE: register codec \"x-good\": expected that the name is "
       "new"},
      {"good, then returns 1", "not_supported: load plug-in FILE: plait_plugin_v1 returned 1"},
      {"built-in name", "register codec \"zstd\": expected that the name is new"},
      {"strange name", "expected that the name has only characters of [A-Za-z0-9_-]"},
      {"no name", "register codec \"\": expected a name, found NULL"},
      {"no summary", "register codec \"x-good\": expected a summary, found NULL"},
      {"no function", "register codec \"x-good\": expected the functions bound, compress and "},
      {"other size", "register codec \"\": expected a structure of 72 bytes, found one of 80"},
      {"no codec", "register codec \"\": expected a structure, found NULL"},
      {"no filter function", "register filter \"x-f\": expected the functions encode and decode"},
      {"other stamp",
       "not_supported: load plug-in FILE: expected a plug-in built against \"plait "},
      {"other stamp", "\", found \"plait 9.9 v7, libc++ 1\": build it anew"},
      {"backend twice", "add backend \"x-memory\": expected a name that is free"},
      {"backend name", "add backend \"x:y\": expected a name of [A-Za-z0-9_-]"}};
  Plugins plugins;
  for (const Case& one : cases) {
    const Behaviour behaviour(one.what);
    std::string text = error_text([&] { plugins.load(PLAIT_HOSTILE_PLUGIN); });
    const std::size_t at = text.find(PLAIT_HOSTILE_PLUGIN);
    REQUIRE(at != std::string::npos);
    text.replace(at, std::string_view(PLAIT_HOSTILE_PLUGIN).size(), "FILE");
    CAPTURE(one.what, one.words, text);
    CHECK(text.find(one.words) != std::string::npos);
    CHECK(plugins.loaded().empty());
    CHECK(plugins.pipelines().codec_names() == default_pipelines().codec_names());
    CHECK(plugins.backends().names() == default_backends().names());
  }
  // The same library, once it behaves.
  const Behaviour behaviour("stamp");
  CHECK(plugins.load(PLAIT_HOSTILE_PLUGIN).codecs == Names{"x-good"});
}

TEST_CASE("PluginsLoad_NameOfAnotherPlugin_IsRefused") {
  const TemporaryDirectory here;
  const fs::path copy = here.path() / "copy.so";
  fs::copy_file(PLAIT_OWN_CODEC, copy);
  Plugins plugins;
  plugins.load(PLAIT_OWN_CODEC);
  CHECK(error_text([&] {
          plugins.load(copy);
        }).ends_with("register codec \"x-runs\": expected that the name is new"));
  CHECK(plugins.loaded().size() == 1);
}

TEST_CASE("PluginsLoad_FileThatIsNoPlugin_IsRefusedInWords") {
  const TemporaryDirectory here;
  const fs::path path = here.path() / "plugin.so";
  const auto refusal = [&] { return error_text([&] { Plugins().load(path); }); };
  const auto starts = [&](const std::string& code, const std::string& rest) {
    const std::string text = refusal();
    CAPTURE(text);
    return text.starts_with(code + ": ") && text.find(path.string()) != std::string::npos &&
           text.find(rest) != std::string::npos;
  };
  CHECK(starts("not_found", "No such file"));
  fs::create_directory(path);
  CHECK(starts("invalid_argument", "directory"));
  fs::remove(path);
  REQUIRE(::mkfifo(path.c_str(), 0600) == 0);
  CHECK(starts("invalid_argument", "FIFO"));
  fs::remove(path);
  write_bytes(path, {});
  CHECK(starts("invalid_argument", "expected a shared library, found a file of 0 bytes"));
  write_bytes(path, Bytes(5000, std::byte{'x'}));
  CHECK(starts("invalid_argument", "expected a shared library, found a file of another kind"));
  fs::remove(path);
  fs::copy_file("/proc/self/exe", path);
  CHECK(starts("invalid_argument", "expected a shared library, found "));
  fs::remove(path);
  fs::copy_file(PLAIT_NOT_A_PLUGIN, path);
  CHECK(starts("invalid_argument", "expected the function plait_plugin_v1, found none"));

  // Cut short anywhere, it kills nobody. Behind the last segment are only names for debuggers.
  const Bytes whole = bytes_of(PLAIT_OWN_CODEC);
  for (const std::size_t bytes : {std::size_t{10}, std::size_t{64}, std::size_t{200},
                                  whole.size() / 8, whole.size() / 4, whole.size() / 2}) {
    fs::remove(path);  // the loader may have the former file mapped
    write_bytes(path, std::span(whole).first(bytes));
    CHECK(starts("invalid_argument", "expected a shared library, found "));
  }
}

TEST_CASE("FunctionCodec_Options_GoToThePlugin") {
  const Behaviour behaviour("options");
  Plugins plugins;
  plugins.load(PLAIT_HOSTILE_PLUGIN);
  CHECK(plugins.pipelines().open("x-good:3", {}).codec->memory_bytes(10) == 30);
  CHECK(error_text([&] { plugins.pipelines().open("x-good:33", {}); }) ==
        "invalid_argument: choose codec \"x-good\": the plug-in refuses the options \"33\"");
  Plugins others;
  others.load(PLAIT_OWN_CODEC);
  CHECK(error_text([&] { others.pipelines().open("x-runs:3", {}); }) ==
        "invalid_argument: choose codec \"x-runs\": expected no options, found \"3\"");
}

TEST_CASE("FunctionCodec_ReportsMoreThanThereIsRoom_IsAnError") {
  const Behaviour behaviour("reports too much");
  Plugins plugins;
  plugins.load(PLAIT_HOSTILE_PLUGIN);
  Bytes raw(100), into(50);
  const OpenPipeline made = plugins.pipelines().open("x-good", {});
  CHECK(error_text([&] { made.codec->compress(raw, into); }) ==
        "bad_state: encode x-good: expected at most 50 bytes, and the plug-in reports 51");
}

}  // namespace plait::test
