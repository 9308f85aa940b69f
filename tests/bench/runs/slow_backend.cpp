// A plug-in with two backends over pread whose speed is known, for the tests of `plait bench`:
// x-late serves one read at a time and sleeps 5 ms before it, or PLAIT_TEST_DELAY; x-capped gives
// 200 MB/s, or PLAIT_TEST_CAP, to all readers together. x-wrong turns a bit of what it reads;
// x-killed ends the process at write number PLAIT_TEST_KILLED to a level that has been committed.
// Both sleepers keep their own account of the truth, because a busy machine wakes them late: how
// long they slept, the time from the begin of the first read to the end of the last one, and the
// bytes. When a level closes they write it to the file that PLAIT_TEST_SERVED names.
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <mutex>
#include <thread>
#include <type_traits>

#include "plait/extend/plugin_in_cpp.h"
#include "plait/registry.h"
#include "support/forwarding_backend.h"

namespace {

using Clock = std::chrono::steady_clock;

std::mutex mutex, device;
double slept = 0, read_bytes = 0;
Clock::time_point first_begin = Clock::time_point::max(), last_end = Clock::time_point::min();

int number_in(const char* variable, int otherwise) {
  const char* const text = std::getenv(variable);
  return text == nullptr ? otherwise : std::atoi(text);
}

void sleep_until(Clock::time_point due) {
  const Clock::time_point before = Clock::now();
  std::this_thread::sleep_until(due);
  const std::lock_guard lock(mutex);
  slept += std::chrono::duration<double>(Clock::now() - before).count();
}

class SlowBackend : public plait::test::ForwardingBackend {
 public:
  using ForwardingBackend::ForwardingBackend;
  ~SlowBackend() override {
    if (const char* const file = std::getenv("PLAIT_TEST_SERVED")) {
      const std::lock_guard lock(mutex);
      const double span = last_end < first_begin  // nothing was read
                              ? 0
                              : std::chrono::duration<double>(last_end - first_begin).count();
      std::ofstream(file) << slept << ' ' << span << ' ' << std::fixed << read_bytes;
    }
  }
  void read(plait::BlockRange blocks, std::span<std::byte> into) final {
    const Clock::time_point begin = Clock::now();
    read_slowly(blocks, into);
    const std::lock_guard lock(mutex);
    first_begin = std::min(first_begin, begin);
    last_end = std::max(last_end, Clock::now());
    read_bytes += static_cast<double>(into.size());
  }

 protected:
  virtual void read_slowly(plait::BlockRange blocks, std::span<std::byte> into) = 0;
};

class LateBackend final : public SlowBackend {
 public:
  using SlowBackend::SlowBackend;
  void read_slowly(plait::BlockRange blocks, std::span<std::byte> into) override {
    const std::lock_guard one_at_a_time(device);
    sleep_until(Clock::now() + std::chrono::milliseconds(number_in("PLAIT_TEST_DELAY", 5)));
    inner().read(blocks, into);
  }
};

class CappedBackend final : public SlowBackend {
 public:
  using SlowBackend::SlowBackend;
  void read_slowly(plait::BlockRange blocks, std::span<std::byte> into) override {
    static Clock::time_point free_again = Clock::now();
    static const double bytes_per_second = 1e6 * number_in("PLAIT_TEST_CAP", 200);
    Clock::time_point due;
    {
      const std::lock_guard lock(mutex);
      const auto taken = std::chrono::duration_cast<Clock::duration>(
          std::chrono::duration<double>(static_cast<double>(into.size()) / bytes_per_second));
      free_again = std::max(free_again, Clock::now()) + taken;
      due = free_again;
    }
    inner().read(blocks, into);
    sleep_until(due);
  }
};

/// Ends the process at its n-th write.
class KilledBackend final : public plait::test::ForwardingBackend {
 public:
  using ForwardingBackend::ForwardingBackend;
  void write(plait::BlockRange blocks, std::span<const std::byte> from) override {
    static std::atomic<int> left = number_in("PLAIT_TEST_KILLED", 1);
    inner().write(blocks, from);
    if (--left == 0) ::kill(::getpid(), SIGKILL);
  }
};

class WrongBackend final : public plait::test::ForwardingBackend {
 public:
  using ForwardingBackend::ForwardingBackend;
  void read(plait::BlockRange blocks, std::span<std::byte> into) override {
    inner().read(blocks, into);
    into[into.size() / 8 * 4] ^= std::byte{2};
  }
};

template <class Slow>
void add(plait::PluginRegistry& registry, const char* name) {
  plait::RegisteredBackend entry = plait::default_backends().find("pread");
  entry.name = name;
  entry.open = plait::open_each_level(
      [open = entry.open](const plait::LevelSpec& level) -> std::unique_ptr<plait::Backend> {
        // Making a store goes well: its files are those of version 1.
        if (std::is_same_v<Slow, KilledBackend> && level.name.ends_with(".1"))
          return open({})->open_level(level);
        return std::make_unique<Slow>(open({})->open_level(level));
      });
  registry.add(entry);
}

}  // namespace

extern "C" PLAIT_PLUGIN_EXPORT std::int32_t plait_plugin_v1(const plait_host* host) {
  return plait::add_in_cpp(host, [](plait::PluginRegistry& registry) {
    add<LateBackend>(registry, "x-late");
    add<CappedBackend>(registry, "x-capped");
    add<WrongBackend>(registry, "x-wrong");
    add<KilledBackend>(registry, "x-killed");
  });
}
