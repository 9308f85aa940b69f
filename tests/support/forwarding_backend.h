// tests/support/forwarding_backend.h: a backend that forwards all calls to another one. A test
// overrides some of them.
#pragma once

#include <memory>
#include <utility>

#include "plait/extend/backend.h"

namespace plait::test {

/// start() is not forwarded. It calls read() and write(), so that overrides of these take effect.
class ForwardingBackend : public Backend {
 public:
  explicit ForwardingBackend(std::unique_ptr<Backend> inner) : inner_(std::move(inner)) {}

  void read(BlockRange blocks, std::span<std::byte> into) override { inner_->read(blocks, into); }
  void write(BlockRange blocks, std::span<const std::byte> from) override {
    inner_->write(blocks, from);
  }
  std::byte* address(std::uint64_t block) override { return inner_->address(block); }
  std::size_t context(std::uint64_t block,
                      std::span<ContextBlock, kMostContextBlocks> blocks) const noexcept override {
    return inner_->context(block, blocks);
  }
  bool needs_base_records(std::uint32_t attribute) const noexcept override {
    return inner_->needs_base_records(attribute);
  }
  void advise(BlockRange blocks, Advice advice) noexcept override {
    inner_->advise(blocks, advice);
  }
  void sync(bool durable) override { inner_->sync(durable); }
  std::uint64_t stored_bytes() const override { return inner_->stored_bytes(); }

 protected:
  Backend& inner() { return *inner_; }

 private:
  std::unique_ptr<Backend> inner_;
};

}  // namespace plait::test
