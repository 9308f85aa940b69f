// A plug-in that behaves as PLAIT_TEST_PLUGIN says, for the tests of the loader.
#include <cstdlib>
#include <stdexcept>
#include <string_view>

#include "plait/extend/plugin_in_cpp.h"
#include "plait/registry.h"

namespace {

std::size_t bound(const void*, std::size_t raw_bytes) { return raw_bytes; }
std::size_t compress(void*, const void*, std::size_t, void*, std::size_t) { return 0; }
std::size_t compress_too_much(void*, const void*, std::size_t, void*, std::size_t into_bytes) {
  return into_bytes + 1;
}
std::int32_t decompress(void*, const void*, std::size_t, void*, std::size_t) { return 1; }
void filter(const void*, const void*, void*, std::size_t, std::size_t) {}

/// Options are "1" to "9".
void* open(const char* options) {
  const std::string_view text = options;
  if (text.size() != 1 || text < "1" || text > "9") return nullptr;
  return new int(text[0] - '0');
}
void close(void* state) { delete static_cast<int*>(state); }
std::size_t memory_bytes(const void* state, std::size_t raw_bytes) {
  return raw_bytes * static_cast<std::size_t>(*static_cast<const int*>(state));
}

plait_codec codec(const char* name) {
  return {sizeof(plait_codec), name, "a codec", nullptr, nullptr, nullptr, bound, compress,
          decompress};
}

std::int32_t behave(const plait_host* host, std::string_view what) {
  plait_codec good = codec("x-good");
  if (what == "returns 3") return 3;
  if (what == "refuses") {
    host->refuse(host, "no licence\nfor this machine");
    host->refuse(host, "a second reason");
    return 0;
  }
  if (what == "throws") throw std::runtime_error("a mistake");
  if (what == "throws 7") throw 7;
  if (what == "name twice") {
    host->add_codec(host, &good);
    host->add_codec(host, &good);
    return 0;  // although the second one was refused
  }
  if (what == "good, then returns 1") return host->add_codec(host, &good), 1;
  if (what == "built-in name") return good = codec("zstd"), host->add_codec(host, &good);
  if (what == "strange name") return good = codec("x y"), host->add_codec(host, &good);
  if (what == "no name") return good.name = nullptr, host->add_codec(host, &good);
  if (what == "no summary") return good.summary = nullptr, host->add_codec(host, &good);
  if (what == "no function") return good.compress = nullptr, host->add_codec(host, &good);
  if (what == "other size") return good.struct_size += 8, host->add_codec(host, &good);
  if (what == "no codec") return host->add_codec(host, nullptr);
  if (what == "no filter function") {
    const plait_filter bad = {sizeof bad, "x-f", "", nullptr, nullptr, filter, nullptr};
    return host->add_filter(host, &bad);
  }
  if (what == "other stamp") return host->cpp_registry(host, "plait 9.9 v7, libc++ 1") == nullptr;
  if (what == "backend twice" || what == "backend name")
    return plait::add_in_cpp(host, [&](plait::PluginRegistry& registry) {
      plait::RegisteredBackend entry = plait::default_backends().find("memory");
      entry.name = what == "backend name" ? "x:y" : "x-memory";
      registry.add(entry);
      registry.add(entry);
    });
  if (what == "reports too much") {
    good.compress = compress_too_much;
    return host->add_codec(host, &good);
  }
  if (what == "options") {
    good.open = open;
    good.close = close;
    good.memory_bytes = memory_bytes;
    return host->add_codec(host, &good);
  }
  if (what == "stamp") {
    if (host->struct_size != sizeof(plait_host) || host->abi_version != PLAIT_PLUGIN_ABI_VERSION ||
        std::string_view(host->version) != PLAIT_VERSION)
      return 1;
  }
  return host->add_codec(host, &good);
}

}  // namespace

extern "C" PLAIT_PLUGIN_EXPORT std::int32_t plait_plugin_v1(const plait_host* host) {
  const char* const what = std::getenv("PLAIT_TEST_PLUGIN");
  return behave(host, what == nullptr ? "" : what);
}
