// An array of zeros whose pages take memory only when they are written.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <span>
#include <type_traits>
#include <utility>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// `Record` is a plain value that is zero if its bytes are. Threads: as an array.
template <class Record>
class ZeroedArray {
  static_assert(std::is_trivially_copyable_v<Record> && std::is_trivially_destructible_v<Record> &&
                alignof(Record) <= alignof(std::max_align_t));

 public:
  ZeroedArray() = default;
  /// Errors: std::bad_alloc.
  explicit ZeroedArray(std::size_t size) : size_(size) {
    if (size == 0) return;
    // Of large blocks, calloc() gives pages that the kernel clears when they are first written.
    records_.reset(static_cast<Record*>(std::calloc(size, sizeof(Record))));
    if (!records_) throw std::bad_alloc();
  }

  explicit ZeroedArray(std::span<const Record> records) : ZeroedArray(records.size()) {
    std::ranges::copy(records, data());
  }
  ZeroedArray(const ZeroedArray& other) : ZeroedArray(std::span<const Record>(other)) {}
  ZeroedArray& operator=(const ZeroedArray& other) { return *this = ZeroedArray(other); }
  ZeroedArray(ZeroedArray&& other) noexcept
      : records_(std::move(other.records_)), size_(std::exchange(other.size_, 0)) {}
  ZeroedArray& operator=(ZeroedArray&& other) noexcept {
    records_ = std::move(other.records_);
    size_ = std::exchange(other.size_, 0);
    return *this;
  }
  ~ZeroedArray() = default;

  std::size_t size() const { return size_; }
  Record* data() { return records_.get(); }
  const Record* data() const { return records_.get(); }
  operator std::span<Record>() { return {data(), size_}; }
  operator std::span<const Record>() const { return {data(), size_}; }

 private:
  struct Free {
    void operator()(Record* records) const { std::free(records); }
  };
  std::unique_ptr<Record, Free> records_;
  std::size_t size_ = 0;
};

PLAIT_END_NAMESPACE
