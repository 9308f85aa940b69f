// tests/support/counting_backend.h: a backend that forwards to another one and counts the calls.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <utility>

#include "plait/extend/backend_registry.h"
#include "support/forwarding_backend.h"

namespace plait::test {

struct BackendCounts {
  std::atomic<std::uint64_t> read_calls = 0, read_blocks = 0, read_bytes = 0;
  std::atomic<std::uint64_t> write_calls = 0, write_blocks = 0, write_bytes = 0;
  std::atomic<std::uint64_t> advise_calls = 0, sync_calls = 0;
};

class CountingBackend final : public ForwardingBackend {
 public:
  /// `counts` outlives this object; several backends may share it.
  CountingBackend(std::unique_ptr<Backend> inner, BackendCounts& counts)
      : ForwardingBackend(std::move(inner)), counts_(counts) {}

  void read(BlockRange blocks, std::span<std::byte> into) override {
    ++counts_.read_calls;
    counts_.read_blocks += blocks.count;
    counts_.read_bytes += into.size();
    inner().read(blocks, into);
  }
  void write(BlockRange blocks, std::span<const std::byte> from) override {
    ++counts_.write_calls;
    counts_.write_blocks += blocks.count;
    counts_.write_bytes += from.size();
    inner().write(blocks, from);
  }
  void start(Transfer& transfer) noexcept override {
    const bool read = transfer.direction == Transfer::Direction::kRead;
    ++(read ? counts_.read_calls : counts_.write_calls);
    ++(read ? counts_.read_blocks : counts_.write_blocks);
    (read ? counts_.read_bytes : counts_.write_bytes) += transfer.memory.size();
    inner().start(transfer);
  }
  void advise(BlockRange blocks, Advice advice) noexcept override {
    ++counts_.advise_calls;
    inner().advise(blocks, advice);
  }
  void sync(bool durable) override {
    if (durable) ++counts_.sync_calls;
    inner().sync(durable);
  }

 private:
  BackendCounts& counts_;
};

using WrapBackend = std::function<std::unique_ptr<Backend>(std::unique_ptr<Backend>)>;
using WrapLevel = std::function<std::unique_ptr<Backend>(Volume& inner, const LevelSpec&)>;

/// A volume that applies `wrap` to each level that it opens.
class WrappedVolume final : public Volume {
 public:
  WrappedVolume(std::unique_ptr<Volume> inner, WrapLevel wrap)
      : inner_(std::move(inner)), wrap_(std::move(wrap)) {}
  std::unique_ptr<Backend> open_level(const LevelSpec& level) override {
    return wrap_(*inner_, level);
  }
  std::uint64_t scratch_bytes() const noexcept override { return inner_->scratch_bytes(); }
  std::uint64_t scratch_bytes_with(std::span<const FutureLevel> levels) const override {
    return inner_->scratch_bytes_with(levels);
  }
  void begin_version(std::uint64_t sequence, std::span<const std::uint64_t> held) override {
    inner_->begin_version(sequence, held);
  }

 private:
  std::unique_ptr<Volume> inner_;
  WrapLevel wrap_;
};

inline OpenVolume wrapped_volume(OpenVolume open, WrapLevel wrap) {
  return [open = std::move(open), wrap = std::move(wrap)](const VolumeSpec& volume) {
    return std::make_unique<WrappedVolume>(open(volume), wrap);
  };
}

/// A registry with the same names and options, which applies `wrap` to every backend that it opens.
inline BackendRegistry wrapped_registry(const BackendRegistry& registry, const WrapBackend& wrap) {
  BackendRegistry result;
  for (const std::string& name : registry.names()) {
    RegisteredBackend entry = registry.find(name);
    entry.open = wrapped_volume(entry.open, [wrap](Volume& inner, const LevelSpec& level) {
      return wrap(inner.open_level(level));
    });
    result.add(std::move(entry));
  }
  result.set_chooser(registry.chooser());
  return result;
}

/// A registry with the same names and options, which counts the calls of every backend in `counts`.
inline BackendRegistry counting_registry(const BackendRegistry& registry, BackendCounts& counts) {
  return wrapped_registry(registry, [&counts](std::unique_ptr<Backend> inner) {
    return std::make_unique<CountingBackend>(std::move(inner), counts);
  });
}

}  // namespace plait::test
