// A plug-in with a backend that breaks promises of plait/extend/backend.h: it does not compare
// checksums.
#include "plait/error.h"
#include "plait/extend/plugin_in_cpp.h"
#include "plait/registry.h"
#include "support/forwarding_backend.h"

namespace {

class TrustingBackend final : public plait::test::ForwardingBackend {
 public:
  using ForwardingBackend::ForwardingBackend;
  void read(plait::BlockRange blocks, std::span<std::byte> into) override {
    try {
      inner().read(blocks, into);
    } catch (const plait::Error& error) {
      if (error.code() != plait::ErrorCode::kCorruption) throw;
    }
  }
};

}  // namespace

extern "C" PLAIT_PLUGIN_EXPORT std::int32_t plait_plugin_v1(const plait_host* host) {
  return plait::add_in_cpp(host, [](plait::PluginRegistry& registry) {
    plait::RegisteredBackend entry = plait::default_backends().find("pread");
    entry.name = "x-trusting";
    entry.open = plait::open_each_level([open = entry.open](const plait::LevelSpec& level) {
      return std::make_unique<TrustingBackend>(open({})->open_level(level));
    });
    registry.add(entry);
  });
}
