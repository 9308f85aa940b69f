// Large arrays in huge pages, and copies into those of a caller. A walk over a large mesh in no
// particular order then misses the processor's tables of pages less often, and the first touch of
// an array costs one page fault for two megabytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

inline constexpr std::uintptr_t kHugePage = std::uintptr_t{2} << 20;

/// Asks the system for huge pages for the part of this memory that they can cover. A wish: if the
/// system does not grant it, nothing is different.
void wish_huge_pages(void* memory, std::size_t bytes) noexcept;

/// Reserves room for `count` elements. REQUIRES: the vector is empty. Errors: std::bad_alloc.
template <class Element>
void reserve_huge(std::vector<Element>& vector, std::size_t count) {
  vector.reserve(count);
  wish_huge_pages(vector.data(), vector.capacity() * sizeof(Element));
}

/// Errors: std::bad_alloc.
template <class Element>
std::vector<Element> huge_vector(std::size_t count, Element value = {}) {
  std::vector<Element> vector;
  reserve_huge(vector, count);
  vector.resize(count, value);
  return vector;
}

/// Allocates in huge pages, and leaves new elements without a value.
template <class Element>
struct HugeAllocator {
  using value_type = Element;
  HugeAllocator() = default;
  template <class Other>
  explicit HugeAllocator(const HugeAllocator<Other>&) noexcept {}

  Element* allocate(std::size_t count) {
    Element* const memory = std::allocator<Element>().allocate(count);
    wish_huge_pages(memory, count * sizeof(Element));
    return memory;
  }
  void deallocate(Element* memory, std::size_t count) noexcept {
    std::allocator<Element>().deallocate(memory, count);
  }
  template <class Other>
  void construct(Other* at) noexcept {
    ::new (static_cast<void*>(at)) Other;
  }
  friend bool operator==(const HugeAllocator&, const HugeAllocator&) { return true; }
};

/// An array that its owner writes before he reads it.
template <class Element>
using HugeArray = std::vector<Element, HugeAllocator<Element>>;

/// Writes the last byte of each huge page that begins in the `size` bytes from array[at] on, before
/// a copy from front to back gets there. Does nothing for arrays of less than two huge pages, and
/// for a huge page that ends behind the array. Linux clears a new huge page towards the byte that
/// is written first: from back to front for a copy that comes to its front, but from front to back
/// for this byte. Copies of blocks into a new array of 77 MB then take as long as one memcpy, and
/// not 1.15 times as long.
inline void touch_huge_pages(std::span<std::byte> array, std::size_t at, std::size_t size) {
  if (array.size() < 2 * kHugePage) return;
  const auto start = reinterpret_cast<std::uintptr_t>(array.data());
  std::uintptr_t last = (start + at + kHugePage - 1) | (kHugePage - 1);
  for (; last - start < at + size + kHugePage - 1 && last - start < array.size(); last += kHugePage)
    array[last - start] = {};
}

PLAIT_END_NAMESPACE
